"""What goes wrong when one plans: all planners give the same outcome, and say why with numbers.

From a map file with its layers to the plan, as a robot's computer does it.
"""
import threading
import time

import numpy as np
import pytest
from mesh_map.base.errors import MeshMapError
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import GetPathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.execution.plan_execution import PlanExecution
from mesh_navigation.execution.planning import SHORT_NAMES, make_planner
from mesh_navigation.plugins.planner import MeshPlanner
from mesh_navigation.plugins.plugin_list import PLANNERS, PluginList
from mesh_navigation.server.slots import ConcurrencySlots
from mesh_navigation.surface.map_loading import load_map

SUCCESS, NO_PATH = GetPathOutcome.SUCCESS, GetPathOutcome.NO_PATH_FOUND
INVALID_START, INVALID_GOAL = GetPathOutcome.INVALID_START, GetPathOutcome.INVALID_GOAL
HERE, THERE = (2.1, 2.2, 0.0), (7.9, 7.6, 0.0)
STORED = {
    "layers": [{"name": "stored", "type": "mesh_layers/StoredLayer"}],
    "edge_cost_factor": 2.0,
}
every_planner = pytest.mark.parametrize("planner", SHORT_NAMES)


@pytest.fixture(scope="module")
def map_with(tmp_path_factory):
    """Maps that were written to a file with costs (V,), and read by a StoredLayer."""
    made = {}

    def get(mesh, costs=None):
        key = mesh.name, b"" if costs is None else costs.tobytes()
        if key not in made:
            path = str(tmp_path_factory.mktemp("map") / "map.h5")
            stored = {} if costs is None else {"stored": costs}
            MapFile.write(path, Mesh(mesh.vertices, mesh.faces, vertex_costs=stored))
            made[key] = load_map(path, {} if costs is None else STORED)
        return made[key]

    return get


def flat(cost=0.0, **costs_where):
    """Costs of the vertices of zoo.grid(): one for all, others where a condition on x, y holds."""
    mesh = zoo.grid()
    costs = np.full(len(mesh.vertices), cost, np.float32)
    for value, condition in costs_where.values():
        costs[condition(*mesh.vertices.T[:2])] = value
    return costs


def planned(mesh_map, planner, start=HERE, goal=THERE, **parameters):
    made = make_planner(mesh_map, planner, parameters)
    return made.make_plan(Pose.at(start), Pose.at(goal))


def check_failure(result, outcome, words):
    """A failure has its outcome, a message with the words, and no path."""
    assert result.outcome == outcome, result.message
    for word in words:
        assert word in result.message
    assert len(result.poses) == 0 and not result.succeeded


# Start and goal. Each: which end, where it is, outcome, words of the message.
PLACES = {
    "1 cm above": ("goal", (7.9, 7.6, 0.01), SUCCESS, ()),
    "1 cm below": ("start", (2.1, 2.2, -0.01), SUCCESS, ()),
    "1 m above": ("goal", (7.9, 7.6, 1.0), INVALID_GOAL, ("goal", "1.00 m from the map", "0.40")),
    "1 m below": ("start", (2.1, 2.2, -1.0), INVALID_START, ("start", "1.00 m from the map")),
    "100 m beside": ("goal", (110.0, 5.0, 0.0), INVALID_GOAL, ("goal", "100.00 m from the map")),
    "100 m above": ("start", (2.1, 2.2, 100.0), INVALID_START, ("start", "100.00 m from")),
    "infinity": ("goal", (np.inf, 0.0, 0.0), INVALID_GOAL, ("goal", "not finite")),
    "no number": ("start", (0.0, np.nan, 0.0), INVALID_START, ("start", "not finite")),
    "1e60": ("goal", (1e60, 0.0, 0.0), INVALID_GOAL, ("goal",)),
}


@every_planner
@pytest.mark.parametrize("place", PLACES)
def test_poses_beside_the_map(map_with, planner, place):
    which, point, outcome, words = PLACES[place]
    ends = (point, THERE) if which == "start" else (HERE, point)
    result = planned(map_with(zoo.grid()), planner, *ends)
    if outcome == SUCCESS:
        assert result.succeeded and "path of" in result.message
        assert np.abs(result.poses[:, 2]).max() < 1e-6  # on the surface, wherever it was asked from
    else:
        check_failure(result, outcome, words)


@every_planner
@pytest.mark.parametrize("end, outcome", [("start", INVALID_START), ("goal", INVALID_GOAL)])
@pytest.mark.parametrize(
    "cost, words",
    [
        (np.inf, ("lethal", "layer stored")),
        (np.nan, ("unknown", "layer stored")),
        (1.5, ("1.5", "cost limit 1", "layer stored")),
    ],
)
def test_blocked_ends(map_with, planner, end, outcome, cost, words):
    x, y = np.round((HERE if end == "start" else THERE)[:2])
    costs = flat(spot=(cost, lambda u, v: (u == x) & (v == y)))
    result = planned(map_with(zoo.grid(), costs), planner)
    if end == "start" and np.isfinite(cost):  # what only costs too much is left
        assert result.succeeded and "begins on closed ground" in result.message
        return
    check_failure(result, outcome, (end, *words))


@every_planner
def test_ends_over_a_hole_and_beside_it(map_with, planner):
    mesh = zoo.hole()
    boundary = mesh.vertices[:, :2].mean(axis=0)
    hole = (*boundary, float(mesh.vertices[0, 2]))
    mesh_map = map_with(mesh)
    start = tuple(mesh.vertices[0])
    distance = np.linalg.norm(mesh.vertices - hole, axis=1).min()
    assert distance > 0.4  # else it is near enough to be on the surface
    check_failure(planned(mesh_map, planner, start, hole), INVALID_GOAL, ("goal", "from the map"))
    opposite = tuple(mesh.vertices[-1])
    around = planned(mesh_map, planner, start, opposite)
    assert around.succeeded
    found = [
        mesh_map.geometry.closest_face(point, 1e-3) is not None for point in around.poses[:, :3]
    ]
    assert all(found)


@every_planner
def test_ends_on_different_components(map_with, planner):
    result = planned(map_with(zoo.two_components()), planner, (1, 1, 0), (8, 1, 0))
    check_failure(result, NO_PATH, ("start is in component 1 of 2", "goal in component 2"))


@every_planner
@pytest.mark.parametrize("where", [HERE, (3.0, 3.0, 0.0), (3.5, 3.5, 0.0), (0.0, 0.0, 0.0)])
def test_start_that_is_the_goal(map_with, planner, where):
    result = planned(map_with(zoo.grid()), planner, where, where)
    assert result.succeeded and len(result.poses) >= 2
    np.testing.assert_allclose(result.poses[:, :3], [where] * len(result.poses), atol=1e-6)
    assert result.cost == pytest.approx(0.0, abs=1e-6)


# Costs. Each: costs of the grid, outcome, words of the message.
COSTS = {
    "all lethal": (flat(np.inf), INVALID_START, ("lethal",)),
    "all unknown": (flat(np.nan), INVALID_START, ("unknown",)),
    "all over the limit": (flat(1.01), INVALID_START, ("cost limit",)),
    "lethal wall": (flat(wall=(np.inf, lambda x, y: x == 5)), NO_PATH, ("11", "lethal")),
    "unknown wall": (flat(wall=(np.nan, lambda x, y: x == 5)), NO_PATH, ("component 1",)),
    "jagged wall": (
        flat(wall=(np.inf, lambda x, y: (x + y == 10) | (x + y == 11))),
        NO_PATH,
        ("21", "lethal"),
    ),
    "costly wall": (flat(wall=(2.0, lambda x, y: x == 5)), NO_PATH, ("component 1",)),
    "wall at the limit": (flat(wall=(1.0, lambda x, y: x == 5)), SUCCESS, ()),
    "negative": (flat(-3.0), SUCCESS, ()),
    "partly negative": (flat(wall=(-1e30, lambda x, y: x == 5)), SUCCESS, ()),
    "all the same": (flat(1.0), SUCCESS, ()),
}


@every_planner
@pytest.mark.parametrize("kind", COSTS)
def test_costs_of_any_kind(map_with, planner, kind):
    costs, outcome, words = COSTS[kind]
    mesh_map = map_with(zoo.grid(), costs)
    result = planned(mesh_map, planner)
    if outcome != SUCCESS:
        check_failure(result, outcome, words)
        return
    assert result.succeeded, result.message
    steps = np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1)
    straight = np.linalg.norm(np.subtract(THERE, HERE))
    assert straight - 1e-6 < steps.sum() < 1.45 * straight
    # No way is free, and none costs less than its length: potentials cannot fall for ever.
    assert result.cost > steps.sum() - 1e-4
    assert result.potential.min() >= 0.0


@every_planner
@pytest.mark.parametrize(
    "name, value",
    [
        ("cost_limit", -0.5),
        ("cost_limit", np.nan),
        ("cost_limit", np.inf),
        ("cost_limit", "many"),
        ("goal_dist_offset", -0.5),
        ("goal_dist_offset", np.nan),
        ("goal_dist_offset", "far"),
        ("publish_vector_field", "perhaps"),
    ],
)
def test_numbers_that_are_none_of_a_parameter(map_with, planner, name, value):
    mesh_map = map_with(zoo.grid())
    with pytest.raises(MeshMapError, match=name):
        make_planner(mesh_map, planner, {name: value})


def test_factors_that_are_negative_are_refused_or_moved_to_zero(map_with):
    mesh_map = map_with(zoo.grid(), flat(0.4))  # of this test alone: its settings change
    with pytest.raises(MeshMapError, match="cost_factor"):
        make_planner(mesh_map, "wave_front", {"cost_factor": -1.0})
    assert mesh_map.set_settings(edge_cost_factor=-1.0).edge_cost_factor == 0.0
    with pytest.raises(MeshMapError, match="edge_cost_factor"):
        mesh_map.set_settings(edge_cost_factor=np.nan)
    result = planned(mesh_map, "dijkstra")
    steps = np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1)
    assert result.succeeded and result.cost == pytest.approx(steps.sum(), rel=1e-5)


@pytest.fixture(scope="module")
def world():
    """Planners by short name on a rough map, start and goal that all of them connect."""
    mesh = zoo.outdoor_world(faces=60_000)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    mesh_map.compute_layers([{"name": "steps", "type": "mesh_layers/HeightDiffLayer"}])
    ends = [Pose.at(mesh.places[name]) for name in ("start", "goal")]
    made = {name: make_planner(mesh_map, name) for name in SHORT_NAMES}
    return made, ends


@every_planner
def test_cancel_at_random_times_and_twice(world, planner):
    made, (start, goal) = world[0][planner], world[1]
    began = time.monotonic()
    expected = made.make_plan(start, goal)
    longest = time.monotonic() - began
    assert expected.succeeded, expected.message
    random = np.random.default_rng(1)
    for index in range(12):
        # another goal each time: nothing is known of it yet
        other = Pose.at(goal.position + [0.01 * index, 0.02 * index, 0.0])
        cancellation = Cancellation()
        timers = [
            threading.Timer(delay, cancellation.cancel, (f"reason {number}",))
            for number, delay in enumerate(random.uniform(0.0, longest, 2))
        ]
        for timer in timers:
            timer.start()
        result = made.make_plan(start, other, 0.0, cancellation)
        canceled_before = cancellation.canceled
        for timer in timers:
            timer.join()
        if result.outcome == GetPathOutcome.CANCELED:
            assert canceled_before and "planning stopped: reason" in result.message
            assert len(result.poses) == 0
        else:
            assert result.succeeded, result.message
    np.testing.assert_array_equal(made.make_plan(start, goal).poses, expected.poses)


@every_planner
def test_a_new_goal_in_the_slot_cancels_the_one_before(world, planner):
    made, (start, goal) = world[0][planner], world[1]
    slots, results = ConcurrencySlots(), {}

    def job(number):
        other = Pose.at(goal.position - [0.02 * number, 0.01 * number, 0.0])

        def run(cancellation):
            results[number] = made.make_plan(start, other, 0.0, cancellation)

        return run

    jobs = [slots.start(0, job(number)) for number in range(1, 6)]
    for each in jobs:
        each.join(60.0)
    assert results[5].succeeded, results[5].message
    for number in set(results) - {5}:  # those that were in time
        assert results[number].outcome in (SUCCESS, GetPathOutcome.CANCELED)


@every_planner
def test_a_plan_without_patience_ends_with_its_outcome_and_harms_no_other(world, planner):
    made, (start, goal) = world[0][planner], world[1]
    other = Pose.at(goal.position + [0.3, -0.3, 0.0])

    def plan_when_patience_is_gone(cancellation):
        while not cancellation.canceled:
            time.sleep(0.001)
        return made.make_plan(start, other, 0.0, cancellation)

    execution = PlanExecution(plan_when_patience_is_gone, patience=0.05, max_retries=0)
    result = execution.run(Cancellation())
    assert result.outcome == GetPathOutcome.PAT_EXCEEDED
    assert "patience of 0.05 s" in result.message
    after = PlanExecution(lambda each: made.make_plan(start, other, 0.0, each), 60.0, 0)
    assert after.run(Cancellation()).succeeded


@every_planner
def test_a_planner_that_throws_is_an_internal_error(world, planner, monkeypatch):
    made, (start, goal) = world[0][planner], world[1]

    def broken(*_):
        raise ZeroDivisionError("odd mesh")

    monkeypatch.setattr(type(made), "plan", broken)
    execution = PlanExecution(lambda each: made.make_plan(start, goal, 0.0, each), 10.0, 3)
    result = execution.run(Cancellation())
    assert result.outcome == GetPathOutcome.INTERNAL_ERROR
    assert "ZeroDivisionError: odd mesh" in result.message
    monkeypatch.undo()
    assert execution.run(Cancellation()).succeeded


@pytest.mark.parametrize(
    "entry, words",
    [
        ({"name": "mmp", "type": "mmp_planner/Absent"}, "mmp_planner/Absent"),
        ({"name": "layer", "type": "mesh_layers/HeightDiffLayer"}, "mesh_layers/HeightDiffLayer"),
        ({"name": "no type"}, "no {name, type}"),
        ({"name": "a b", "type": "wave_front_planner/WaveFrontPlanner"}, "no name of letters"),
        (dict(PLANNERS.default[0]), "before it"),
    ],
)
def test_one_odd_plugin_leaves_the_others(entry, words):
    found = PluginList(PLANNERS, [*PLANNERS.default, entry])
    assert found.names == [each["name"] for each in PLANNERS.default]
    assert len(found.complaints) == 1 and words in found.complaints[0]
    mesh = zoo.grid(cells=2)
    prepared = found.prepared(MeshMap(mesh.vertices, mesh.faces))
    assert all(isinstance(prepared[name], MeshPlanner) for name in found.names)


@every_planner
@pytest.mark.parametrize("length", [1e-3, 0.99, 7.0])
def test_an_orientation_that_is_not_of_length_1(map_with, planner, length):
    goal = Pose(np.array(THERE), length * np.array([0.0, 0.0, np.sin(0.4), np.cos(0.4)]))
    made = make_planner(map_with(zoo.grid()), planner)
    result = made.make_plan(Pose.at(HERE), goal)
    assert result.succeeded
    np.testing.assert_allclose(
        result.poses[-1, 3:], [0.0, 0.0, np.sin(0.4), np.cos(0.4)], atol=1e-6
    )
