"""Planning again: to the same goal from elsewhere, after changes of costs, and side by side."""

import threading

import numpy as np
import pytest

from mesh_msgs import zoo
from navigation_test_maps import ALL_PLANNERS, MapWithCosts, planner_on

from mesh_map.costs.settings import MapSettings
from mesh_map.distance.dijkstra import DijkstraField, DijkstraSolver
from mesh_map.distance.wave_front import WaveFrontField, WaveFrontSolver
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.planners.wave_front import WaveFrontPlanner

pytestmark = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)

MESH = zoo.jittered_plane(cells=30, size=30.0)
COUNT = len(MESH.vertices)
WEIGHTED = MapSettings(edge_cost_factor=1.0)


def random_costs(seed=0):
    return np.random.default_rng(seed).uniform(0, 0.9, COUNT).astype(np.float32)


def test_no_plan_is_refused_for_a_field_that_was_mended(cls, monkeypatch, calls):
    """One that is computed anew has the last word, once."""
    mesh_map = MapWithCosts(MESH, random_costs(), settings=WEIGHTED)
    planner, start, goal = planner_on(mesh_map, cls), Pose.at([2, 2, 0]), Pose.at([27, 26, 0])
    assert planner.make_plan(start, goal).succeeded

    def mended(self, *args, **kwargs):
        self.reaches = lambda vertices: np.zeros(len(vertices), np.bool_)

    mesh_map.costs = mesh_map.costs.copy()
    mesh_map.costs[np.argmin(np.hypot(*(MESH.vertices[:, :2] - [15, 15]).T))] = np.inf
    with monkeypatch.context() as patch:
        for owner in (DijkstraField, WaveFrontField):
            patch.setattr(owner, "update", mended)
        assert planner.make_plan(start, goal).succeeded
    assert planner.make_plan(start, goal).succeeded
    found = [name for name in calls if name != "update"]
    assert found[:3] == ["solve", "extend", "solve"]
    assert found.count("extend") == 2  # the new field serves from then on


def random_pose(rng):
    return Pose.at([*rng.uniform(1, 29, 2), 0])


@pytest.fixture
def calls(monkeypatch):
    """Names of the kernels' methods in the order of their calls: solve, extend, update."""
    names = []

    def counted(owner, name):
        original = getattr(owner, name)

        def call(self, *args, **kwargs):
            names.append(name)
            length = len(names)
            result = original(self, *args, **kwargs)
            del names[length:]  # a solve extends a new field
            return result

        monkeypatch.setattr(owner, name, call)

    for owner, name in (
        (DijkstraSolver, "solve"),
        (DijkstraField, "extend"),
        (DijkstraField, "update"),
        (WaveFrontSolver, "solve"),
        (WaveFrontField, "extend"),
        (WaveFrontField, "update"),
    ):
        counted(owner, name)
    return names


def check_like_new(result, mesh_map, cls, start, goal, **parameters):
    """Planning again is as good as planning for the first time."""
    fresh = planner_on(mesh_map, cls, **parameters).make_plan(start, goal)
    assert result.outcome == fresh.outcome
    if not result.succeeded:
        return
    assert result.cost == pytest.approx(fresh.cost, rel=1e-4)
    lengths = [
        np.linalg.norm(np.diff(r.poses[:, :3], axis=0), axis=1).sum() for r in (result, fresh)
    ]
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-2)
    known = np.isfinite(fresh.potential) & np.isfinite(result.potential)
    np.testing.assert_allclose(result.potential[known], fresh.potential[known], rtol=1e-4)
    assert known.sum() > 3


def test_the_same_goal_is_searched_once(cls, calls):
    mesh_map = MapWithCosts(MESH, random_costs())
    planner, rng = planner_on(mesh_map, cls), np.random.default_rng(1)
    goal = random_pose(rng)
    results = [(start, planner.make_plan(start, goal)) for start in map(random_pose, [rng] * 6)]
    assert calls == ["solve"] + ["extend"] * 5
    for start, result in results:
        check_like_new(result, mesh_map, cls, start, goal)


def test_goals_that_differ_are_kept_apart(cls, calls):
    planner, rng = planner_on(MapWithCosts(MESH), cls), np.random.default_rng(2)
    start, *goals = (random_pose(rng) for _ in range(5))
    for goal in goals[:3] * 2:
        planner.make_plan(start, goal)
    assert calls == ["solve"] * 3 + ["extend"] * 3
    planner.make_plan(start, goals[3])
    planner.make_plan(start, goals[0])  # had to go
    assert calls[6:] == ["solve"] * 2
    planner.make_plan(start, goals[2])
    assert calls[8:] == ["extend"]


@pytest.mark.parametrize("settings", [MapSettings(), WEIGHTED])
def test_after_few_changes_the_field_is_mended(cls, calls, settings):
    mesh_map = MapWithCosts(MESH, random_costs(), settings=settings)
    planner, rng = planner_on(mesh_map, cls, cost_limit=0.95), np.random.default_rng(3)
    goal = random_pose(rng)
    planner.make_plan(random_pose(rng), goal)
    outcomes, mended = [], 0
    for _ in range(12):
        mesh_map.costs = mesh_map.costs.copy()
        where = rng.integers(COUNT, size=15)
        choices = np.float32([np.inf, np.nan, 2.0, 0.0, 0.3, 0.9])
        mesh_map.costs[where] = rng.choice(choices, 15)
        start = random_pose(rng)
        del calls[:]
        result = planner.make_plan(start, goal)
        outcomes.append(result.outcome)
        mended += calls[:2] == ["update", "extend"]
        check_like_new(result, mesh_map, cls, start, goal, cost_limit=0.95)
    assert outcomes.count(0) > 6 and mended > 6


def test_obstacles_on_a_free_map_come_and_go(cls, calls):
    mesh_map = MapWithCosts(MESH)
    planner = planner_on(mesh_map, cls)
    start, goal = Pose.at([2, 15, 0]), Pose.at([28, 15, 0])
    planner.make_plan(start, goal)
    wall = (np.abs(MESH.vertices[:, 0] - 15) < 1.2) & (np.abs(MESH.vertices[:, 1] - 15) < 4)
    assert 10 < wall.sum() < COUNT / 8
    for blocked in (np.nan, 0.0, np.inf, 0.0):
        mesh_map.costs = np.where(wall, blocked, 0.0)
        del calls[:]
        result = planner.make_plan(start, goal)
        assert result.succeeded and calls == ["update", "extend"]
        assert (np.abs(result.poses[:, 1] - 15).max() > 3) == (blocked != 0)
        check_like_new(result, mesh_map, cls, start, goal)


def test_what_does_not_count_changes_nothing(cls, calls):
    mesh_map = MapWithCosts(MESH, random_costs())
    planner = planner_on(mesh_map, cls)
    start, goal = Pose.at([2, 15, 0]), Pose.at([28, 15, 0])
    first = planner.make_plan(start, goal)
    mesh_map.costs = random_costs(8)
    del calls[:]
    again = planner.make_plan(start, goal)
    counts = cls is WaveFrontPlanner
    assert calls == ["update", "extend"] if counts else calls == ["extend"]
    assert np.array_equal(first.poses, again.poses) == (not counts)


def test_costs_of_the_same_numbers_are_no_change(cls, calls):
    mesh_map = MapWithCosts(MESH, random_costs(), settings=WEIGHTED)
    planner, rng = planner_on(mesh_map, cls), np.random.default_rng(4)
    start, goal = random_pose(rng), random_pose(rng)
    first = planner.make_plan(start, goal)
    mesh_map.costs = mesh_map.costs.copy()
    again = planner.make_plan(start, goal)
    assert calls[0] == "solve" and "solve" not in calls[1:]
    assert np.array_equal(first.poses, again.poses)
    assert np.array_equal(first.potential, again.potential)


def test_other_parameters_count_from_the_next_plan_on(cls, monkeypatch):
    costs = random_costs()
    mesh_map = MapWithCosts(MESH, costs)
    planner, rng = planner_on(mesh_map, cls), np.random.default_rng(5)
    start, goal = Pose.at([2, 15, 0]), Pose.at([28, 15, 0])
    costs[(MESH.vertices[:, 0] == 15) | (np.abs(MESH.vertices[:, 0] - 15) < 1.2)] = 0.95
    mesh_map.costs = costs
    original = planner._track

    def changed_meanwhile(*args):
        assert planner.set_parameters({"cost_limit": 0.92, "stranger": 1}) == []
        return original(*args)

    monkeypatch.setattr(planner, "_track", changed_meanwhile)
    assert planner.make_plan(start, goal).succeeded
    monkeypatch.undo()
    result = planner.make_plan(start, goal)
    assert result.outcome == GetPathOutcome.NO_PATH_FOUND and "cost limit 0.92" in result.message
    assert planner.set_parameters({"cost_limit": -3}) == [
        "cost_limit is -3, outside of [0.0, 10.0]: 0.0 is used"
    ]
    assert "it stays 0.0" in planner.set_parameters({"cost_limit": "high"})[0]
    assert planner.make_plan(start, goal).outcome == GetPathOutcome.INVALID_START
    assert planner.set_parameters({"cost_limit": 1.0}) == []
    for _ in range(2):
        start = random_pose(rng)
        check_like_new(planner.make_plan(start, goal), mesh_map, cls, start, goal)


def test_a_field_in_use_is_not_changed_by_another_plan(cls, monkeypatch):
    mesh_map = MapWithCosts(MESH, random_costs(), settings=WEIGHTED)
    planner = planner_on(mesh_map, cls)
    start, goal = Pose.at([2, 15, 0]), Pose.at([28, 15, 0])
    expected = planner.make_plan(start, goal)
    inside, go_on, results = threading.Event(), threading.Event(), []
    original = planner._track

    def slow(*args):
        if not inside.is_set():
            inside.set()
            assert go_on.wait(60)
        return original(*args)

    monkeypatch.setattr(planner, "_track", slow)
    thread = threading.Thread(target=lambda: results.append(planner.make_plan(start, goal)))
    thread.start()
    assert inside.wait(60)
    wall = (np.abs(MESH.vertices[:, 0] - 15) < 1.2) & (MESH.vertices[:, 1] > 3)
    mesh_map.costs = np.where(wall, np.inf, mesh_map.costs)
    around = planner.make_plan(start, goal)
    go_on.set()
    thread.join(60)
    assert np.array_equal(results[0].poses, expected.poses)
    assert np.array_equal(results[0].potential, expected.potential)
    assert around.cost > 1.1 * expected.cost and around.poses[:, 1].min() < 4
    check_like_new(planner.make_plan(start, goal), mesh_map, cls, start, goal)


def test_what_a_result_holds_stays_as_it_is(cls):
    mesh_map = MapWithCosts(MESH, random_costs())
    planner, goal = planner_on(mesh_map, cls), Pose.at([28, 15, 0])
    first = planner.make_plan(Pose.at([20, 15, 0]), goal)
    kept = first.potential.copy()
    assert not first.potential.flags.writeable and np.isinf(kept).any()
    planner.make_plan(Pose.at([1, 2, 0]), goal)
    mesh_map.costs = random_costs(7)
    planner.make_plan(Pose.at([1, 2, 0]), goal)
    assert np.array_equal(first.potential, kept)
