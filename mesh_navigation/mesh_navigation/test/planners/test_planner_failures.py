"""Failures of the planners: the right outcome, and a message with numbers."""

import threading

import numpy as np
import pytest

from mesh_msgs import zoo
from mesh_msgs_hdf5.formats.importer import read_mesh
from navigation_test_maps import ALL_PLANNERS, MapWithCosts, data_file, planner_on, vertex_at

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.pose import Pose

pytestmark = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)
HERE, THERE = Pose.at([2.1, 2.1, 0]), Pose.at([8.1, 8.1, 0])


def grid_map(lethal=None, **layers):
    mesh = zoo.grid()
    costs = np.zeros(len(mesh.vertices), np.float32)
    if lethal is not None:
        costs[vertex_at(mesh, lethal)] = np.inf
    return MapWithCosts(mesh, costs, layers)


def plan(cls, mesh_map, start=HERE, goal=THERE, tolerance=0.0, **parameters):
    return planner_on(mesh_map, cls, **parameters).make_plan(start, goal, tolerance)


@pytest.mark.parametrize("what, outcome", [("start", 52), ("goal", 53)])
@pytest.mark.parametrize(
    "pose, words",
    [
        (Pose.at([5, 5, 3.2]), "(5.00, 5.00, 3.20) is 3.20 m from the map, allowed are 0.40 m"),
        (Pose.at([12, 5, 0]), "is 2.00 m from the map"),
        (Pose.at([np.nan, 0, 0]), "position (nan, 0.00, 0.00) is not finite"),
        (Pose(np.zeros(3), np.zeros(4)), "is no rotation (none at all: w = 1)"),
    ],
)
def test_poses_that_are_none_of_the_map(cls, what, outcome, pose, words):
    ends = (pose, THERE) if what == "start" else (HERE, pose)
    result = plan(cls, grid_map(), *ends)
    assert result.outcome == outcome
    assert result.message.startswith(what) and words in result.message
    assert len(result.poses) == 0 and not result.succeeded


def test_a_pose_a_little_above_or_below_the_surface_is_on_it(cls):
    result = plan(cls, grid_map(), Pose.at([2.1, 2.1, 0.39]), Pose.at([8.1, 8.1, -0.39]))
    assert result.succeeded
    assert result.poses[[0, -1], :3] == pytest.approx(np.array([[2.1, 2.1, 0], [8.1, 8.1, 0]]))


@pytest.mark.parametrize("what, outcome, blocked", [("start", 52, HERE), ("goal", 53, THERE)])
@pytest.mark.parametrize(
    "cost, words",
    [
        (np.inf, "is lethal"),
        (np.nan, "is unknown (NaN)"),
        (1.5, "is of cost 1.5, over the cost limit 1"),
    ],
)
def test_blocked_ends_name_the_vertex_and_the_layer(cls, what, outcome, blocked, cost, words):
    mesh = zoo.grid()
    vertex = vertex_at(mesh, blocked.position)
    costs = np.zeros(len(mesh.vertices), np.float32)
    costs[vertex] = cost
    layers = {"roughness": np.zeros_like(costs), "inflation": costs}
    result = plan(cls, MapWithCosts(mesh, costs, layers))
    if what == "start" and cost == 1.5:  # it is left
        assert result.succeeded and "it begins on closed ground" in result.message
        return
    assert result.outcome == outcome
    assert result.message.startswith(f"{what} ({blocked.position[0]:.2f}")
    assert f"nearest vertex {vertex}, 0.14 m away, {words} in layer inflation" in result.message


def test_start_is_blamed_before_the_goal(cls):
    nowhere = Pose.at([50, 0, 0])
    assert plan(cls, grid_map(), nowhere, nowhere).outcome == GetPathOutcome.INVALID_START


def test_costs_up_to_the_limit_are_passed(cls):
    mesh = zoo.grid()
    at_limit = MapWithCosts(mesh, np.full(len(mesh.vertices), 0.5))
    assert plan(cls, at_limit, cost_limit=0.5).succeeded
    assert plan(cls, at_limit, cost_limit=0.499).outcome == GetPathOutcome.INVALID_START


def test_components_are_named(cls):
    result = plan(cls, MapWithCosts(zoo.two_components()), Pose.at([1, 1, 0]), Pose.at([8, 1, 0]))
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND
    assert result.message == "no path: start is in component 1 of 2, goal in component 2"


def test_components_of_the_botanical_garden(cls):
    mesh, _ = read_mesh(str(data_file("botanical_garden_gazebo.ply")))
    mesh_map = MapWithCosts(mesh)
    labels = mesh_map.topology.components
    # The first vertices of two components that lie farther apart than any snapping.
    first = int(np.flatnonzero(labels == 0)[0])
    distances = np.linalg.norm(mesh.vertices - mesh.vertices[first], axis=1)
    second = int(
        np.flatnonzero((labels != 0) & (distances > 5) & np.isin(range(len(labels)), mesh.faces))[0]
    )
    result = plan(cls, mesh_map, Pose.at(mesh.vertices[first]), Pose.at(mesh.vertices[second]))
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND
    assert "of 382, goal in component" in result.message


def test_a_wall_in_one_component_is_counted(cls):
    mesh = zoo.grid()
    costs = np.where(mesh.vertices[:, 0] == 5.0, np.inf, 0.0)
    result = plan(cls, MapWithCosts(mesh, costs))
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND
    assert "55 of 121 vertices of component 1 can be reached from the goal" in result.message
    assert "11 vertices of the map are lethal" in result.message
    assert np.isfinite(result.potential).sum() == 55


class TestTolerance:
    def test_blocked_goal(self, cls):
        result = plan(cls, grid_map(lethal=[8, 8, 0]), tolerance=1.5)
        assert result.outcome == GetPathOutcome.SUCCESS
        # No face around (8, 8) may be crossed; on the diagonals beyond two points are as near.
        assert sorted(result.poses[-1, :2]) == pytest.approx([7.6, 8.6])
        assert "0.71 m from the goal (tolerance 1.50 m), because goal (8.10" in result.message
        assert np.allclose(result.poses[-1, 3:], THERE.orientation, atol=1e-6)

    def test_blocked_goal_beyond_tolerance(self, cls):
        result = plan(cls, grid_map(lethal=[8, 8, 0]), tolerance=0.5)
        assert result.outcome == GetPathOutcome.INVALID_GOAL
        assert "of 1 vertices within the tolerance of 0.50 m none can be reached" in result.message

    def test_goal_off_the_map(self, cls):
        result = plan(cls, grid_map(), goal=Pose.at([10.8, 5, 0]), tolerance=1.0)
        assert result.poses[-1, :3].tolist() == [10, 5, 0]
        assert "0.80 m from the goal" in result.message

    @pytest.mark.parametrize("tolerance, text", [(1e300, "1e+300 m"), (np.inf, "inf m")])
    def test_of_any_size(self, cls, tolerance, text):
        result = plan(cls, grid_map(), goal=Pose.at([40, 5, 0]), tolerance=tolerance)
        assert result.poses[-1, :3].tolist() == [10, 5, 0]
        assert f"30.00 m from the goal (tolerance {text})" in result.message

    def test_goal_in_another_component(self, cls):
        two = MapWithCosts(zoo.two_components(gap=0.5))
        result = plan(cls, two, Pose.at([1, 1, 0]), Pose.at([5.6, 1.1, 0]), tolerance=1.0)
        assert result.poses[-1, :3] == pytest.approx([5, 1.1, 0])

    def test_goal_beside_a_way_of_single_vertices(self, cls):
        mesh = zoo.grid()
        x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
        mesh_map = MapWithCosts(mesh, np.where((y == 5) | (x < 3.5), 0, np.inf))
        result = plan(cls, mesh_map, goal=Pose.at([8.2, 6.1, 0]), tolerance=1.5)
        assert result.succeeded, result.message
        # The way is an edge wide. Vertices are what can be reached of it.
        assert result.poses[-1, :3].tolist() == [8, 5, 0]

    def test_goal_that_can_be_reached_is_reached(self, cls):
        assert plan(cls, grid_map(), tolerance=5.0).poses[-1, :3] == pytest.approx([8.1, 8.1, 0])

    def test_start_gets_none(self, cls):
        start = Pose.at([-0.8, 5, 0])
        assert plan(cls, grid_map(), start, tolerance=2.0).outcome == GetPathOutcome.INVALID_START

    @pytest.mark.parametrize("tolerance", [-1.0, np.nan])
    def test_that_is_none(self, cls, tolerance):
        result = plan(cls, grid_map(), tolerance=tolerance)
        assert result.outcome == GetPathOutcome.INVALID_GOAL and "tolerance" in result.message


def test_cancel_before_the_plan_counts(cls):
    cancellation = Cancellation()
    cancellation.cancel("too early")
    result = planner_on(grid_map(), cls).make_plan(HERE, THERE, 0.0, cancellation)
    assert (result.outcome, result.message) == (51, "planning stopped: too early")


@pytest.mark.parametrize("step", ["_solved", "_track", "_vectors"])
def test_cancel_in_the_middle_counts(cls, step, monkeypatch):
    planner, cancellation = planner_on(grid_map(), cls), Cancellation()
    original = getattr(planner, step)

    def canceled_meanwhile(*args):
        cancellation.cancel("enough")
        return original(*args)

    monkeypatch.setattr(planner, step, canceled_meanwhile)
    result = planner.make_plan(HERE, THERE, 0.0, cancellation)
    assert (result.outcome, result.message) == (51, "planning stopped: enough")
    monkeypatch.undo()
    again = planner.make_plan(HERE, THERE)
    fresh = planner_on(grid_map(), cls).make_plan(HERE, THERE)
    assert again.succeeded and np.array_equal(again.poses, fresh.poses)


@pytest.fixture(scope="module")
def world():
    """100,000 faces, and poses far apart that can reach each other."""
    mesh_map = MapWithCosts(zoo.outdoor_world(faces=100_000))
    labels = mesh_map.topology.components
    ends = np.flatnonzero(labels == np.bincount(labels).argmax())[::997]
    return mesh_map, [Pose.at(mesh_map.vertices[end]) for end in ends]


def test_cancel_at_random_times_is_never_lost(cls, world):
    planner, poses = planner_on(world[0], cls), world[1]
    rng = np.random.default_rng(0)
    for delay in rng.uniform(0, 0.01, 50):
        start, goal = (poses[index] for index in rng.integers(len(poses), size=2))
        cancellation = Cancellation()
        timer = threading.Timer(delay, cancellation.cancel)
        timer.start()
        result = planner.make_plan(start, goal, 0.0, cancellation)
        before_answer = cancellation.canceled
        timer.join()
        assert result.outcome in (0, 51)
        assert result.outcome == 0 or before_answer


def test_plans_side_by_side_do_not_disturb_each_other(cls, world):
    planner, (start, *_, goal) = planner_on(world[0], cls), world[1]
    expected = [planner.make_plan(start, goal).poses, planner.make_plan(goal, start).poses]
    results = [None] * 8

    def work(index):
        ends = (start, goal) if index % 2 == 0 else (goal, start)
        results[index] = planner.make_plan(*ends).poses

    threads = [threading.Thread(target=work, args=(index,)) for index in range(len(results))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for index, poses in enumerate(results):
        assert np.array_equal(poses, expected[index % 2])
