"""A goal that only static layers block is told from one that sensors may open."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from mesh_msgs import zoo
from navigation_test_maps import ALL_PLANNERS, MapWithCosts, planner_on

from mesh_map.costs.cleared_costs import ClearedCosts
from mesh_map.costs.edge_weights import PlanningCosts
from mesh_map.costs.settings import MapSettings
from mesh_map.map.mesh_map import MeshMap
from mesh_navigation.base.outcomes import GetPathOutcome as Outcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.planners.surface_planner import SurfacePlanner

EACH_PLANNER = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)
GRID = zoo.grid(cells=80, size=8.0)
X, Y, _ = GRID.vertices.T
LAYERS = [
    {"name": "walls", "type": "mesh_layers/HeightDiffLayer"},
    {"name": "obstacles", "type": "mesh_layers/ObstacleLayer"},
    {"name": "slopes", "type": "mesh_layers/SteepnessLayer", "params": {"threshold": 1.5}},
]
INFLATION = {
    "name": "inflation",
    "type": "mesh_layers/InflationLayer",
    "params": {"inscribed_radius": 0.25, "inflation_radius": 0.3, "inscribed_value": 2.0},
}
STATIC = "walls", "inflation"  # in which what is lethal in others is lethal, too
HERE, INSIDE = [1.0, 1.0, 0.0], [5.5, 5.5, 0.0]


def room_map(door, inflation=True):
    """A floor with a room: a low wall around (5.5, 5.5), 3 m wide, with or without a door."""
    beside = np.maximum(np.abs(X - 5.5), np.abs(Y - 5.5))
    wall = np.abs(beside - 1.5) < 0.04
    if door:
        wall &= ~((X < 5.0) & (np.abs(Y - 5.5) < 0.7))
    vertices = GRID.vertices.copy()
    vertices[wall, 2] = 0.25
    mesh_map = MeshMap(vertices, GRID.faces)
    mesh_map.compute_layers([*LAYERS, INFLATION] if inflation else LAYERS)
    assert not mesh_map.layer_errors
    return mesh_map


def see(mesh_map, *places):
    """Obstacles at x and y."""
    points = [[x, y, 0.5] for x, y in places]
    layer = mesh_map.layers["obstacles"]
    assert layer.insert_cloud(mesh_map, points, (1.0, 1.0, 2.0), 0.0) > 0
    mesh_map.refresh_layer("obstacles")


DOOR = [(4.0, 5.5 + offset) for offset in np.arange(-0.8, 0.85, 0.05)]


def plan(cls, mesh_map, goal, start=HERE, tolerance=0.0, radius=0.0):
    planner = cls()
    planner.body = Body(mesh_map.geometry, RobotShape(radius=radius))
    assert planner.initialize("planner", mesh_map, {}) == []
    return planner.make_plan(Pose.at(start), Pose.at(goal), tolerance)


def check(result, outcome, lasting, *layers):
    assert (result.outcome, result.lasting) == (outcome, lasting), result.message
    words = "; whatever sensors see, it is blocked by layer"
    if not lasting:
        assert words not in result.message
        return
    _, _, names = result.message.partition(words)
    assert names.lstrip("s").strip().split(", ") == list(layers), result.message


@EACH_PLANNER
def test_a_room_without_a_door(cls):
    mesh_map = room_map(door=False)
    check(plan(cls, mesh_map, INSIDE), Outcome.NO_PATH_FOUND, True, *STATIC)
    see(mesh_map, (2.5, 2.5), (5.5, 5.0), *DOOR)
    check(plan(cls, mesh_map, INSIDE), Outcome.NO_PATH_FOUND, True, *STATIC)
    bare = room_map(door=False, inflation=False)
    see(bare, *DOOR)
    check(plan(cls, bare, INSIDE), Outcome.NO_PATH_FOUND, True, "walls")
    check(plan(cls, bare, INSIDE, radius=0.3), Outcome.NO_PATH_FOUND, True, "walls")


@EACH_PLANNER
@pytest.mark.parametrize("radius", [0.0, 0.2])
def test_a_door_that_is_blocked(cls, radius):
    mesh_map = room_map(door=True)
    assert plan(cls, mesh_map, INSIDE, radius=radius).succeeded
    see(mesh_map, *DOOR)
    check(plan(cls, mesh_map, INSIDE, radius=radius), Outcome.NO_PATH_FOUND, False)
    # A door that is too narrow for the robot stays so.
    found = plan(cls, mesh_map, INSIDE, radius=0.8)
    check(found, Outcome.NO_PATH_FOUND, True, *STATIC)
    mesh_map.clear_layers()
    assert plan(cls, mesh_map, INSIDE, radius=radius).succeeded


@EACH_PLANNER
def test_what_the_goal_is_on(cls):
    mesh_map = room_map(door=True)
    see(mesh_map, (2.5, 5.5), (7.0, 5.5))
    goals = {
        (7.02, 5.5, 0.2): (True, *STATIC),  # something was seen there, too
        (6.72, 5.5, 0.0): (True, *STATIC),
        (2.53, 5.53, 0.0): (False,),
        (2.3, 5.53, 0.0): (False,),
    }
    for goal, expected in goals.items():
        check(plan(cls, mesh_map, goal), Outcome.INVALID_GOAL, *expected)
    # Too near to a wall, for the body; within the tolerance there is room, or not.
    for goal, expected in (([6.5, 5.5, 0.0], (True, *STATIC)), ([2.0, 5.53, 0.0], (False,))):
        found = plan(cls, mesh_map, goal, radius=0.6)
        check(found, Outcome.INVALID_GOAL, *expected)
    assert plan(cls, mesh_map, [6.72, 5.5, 0.0], tolerance=0.5).succeeded
    found = plan(cls, mesh_map, [6.72, 5.5, 0.0], tolerance=0.02)
    check(found, Outcome.INVALID_GOAL, True, *STATIC)
    off = plan(cls, mesh_map, [20.0, 5.5, 0.0])
    assert (off.outcome, off.lasting) == (Outcome.INVALID_GOAL, True)
    assert "whatever sensors see" not in off.message


@EACH_PLANNER
def test_a_start_is_never_blocked_for_good(cls):
    """The robot may be moved away from there."""
    mesh_map = room_map(door=False)
    for start in ([7.0, 5.5, 0.25], [20.0, 0.0, 0.0]):
        found = plan(cls, mesh_map, INSIDE, start=start)
        check(found, Outcome.INVALID_START, False)


@EACH_PLANNER
def test_without_layers_that_can_be_cleared_one_plan_is_enough(cls, monkeypatch):
    mesh = room_map(door=False)
    static = MeshMap(mesh.vertices, mesh.faces)
    static.compute_layers([LAYERS[0]])
    planner, plans = planner_on(static, cls), []
    original = SurfacePlanner._plan

    def counted(self, *arguments):
        plans.append(arguments)
        return original(self, *arguments)

    monkeypatch.setattr(SurfacePlanner, "_plan", counted)
    found = planner.make_plan(Pose.at(HERE), Pose.at(INSIDE))
    check(found, Outcome.NO_PATH_FOUND, True, "walls")
    assert len(plans) == 1


class SensedMap(MapWithCosts):
    """Costs, and what they are without sensors."""

    def __init__(self, mesh, costs, static):
        super().__init__(mesh, costs)
        self.static = np.float32(static)

    def cleared_costs(self):
        return ClearedCosts(PlanningCosts(0, self.static, self.geometry, MapSettings()), {})


@EACH_PLANNER
@pytest.mark.parametrize("seed", range(3))
def test_exactly_where_static_costs_leave_no_path(cls, seed):
    """Against connected components of vertices that are open in the static costs."""
    mesh, random = zoo.jittered_plane(cells=24), np.random.default_rng(seed)
    count = len(mesh.vertices)
    kinds = set()
    for _ in range(25):
        static = np.where(random.random(count) < 0.47, np.inf, 0.0)
        costs = np.where(random.random(count) < 0.2, np.inf, static)
        mesh_map = SensedMap(mesh, costs, static)
        start, goal = random.choice(np.flatnonzero(np.isfinite(costs)), 2, replace=False)
        found = planner_on(mesh_map, cls).make_plan(
            Pose.at(mesh.vertices[start]), Pose.at(mesh.vertices[goal])
        )
        edges = mesh_map.topology.edges.astype(int)
        edges = edges[np.isfinite(static[edges]).all(axis=1)]
        graph = csr_matrix((np.ones(len(edges)), edges.T), shape=(count, count))
        parts = connected_components(graph, directed=False)[1]
        if found.succeeded:
            assert parts[start] == parts[goal] and not found.lasting
            kinds.add("path")
            continue
        assert found.outcome == Outcome.NO_PATH_FOUND, found.message
        assert found.lasting == (parts[start] != parts[goal])
        kinds.add(found.lasting)
    assert kinds == {"path", True, False}
