"""A start on ground that only costs too much, or is only too near to lethal ground for the robot's
body, is left by the shortest way; a goal there is replaced within the tolerance."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from mesh_msgs import zoo
from navigation_test_maps import ALL_PLANNERS, MapWithCosts, planner_on

from mesh_navigation.base.outcomes import GetPathOutcome as Outcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.planners.dijkstra import DijkstraMeshPlanner

GRID = zoo.grid(cells=80, size=8.0)
XY = GRID.vertices[:, :2].astype(np.float64)
X, Y = XY.T
FINE = zoo.jittered_plane(cells=60, size=8.0)
GOAL = [7.6, 7.6, 0.0]
RING, OVER = 0.5, 2.0  # m; a cost over the limit of 1.0
EACH_PLANNER = pytest.mark.parametrize("cls", ALL_PLANNERS, ids=lambda cls: cls.__name__)


def gaps(points, others):
    """(N,) m, from each point to the nearest of others."""
    return np.linalg.norm(points[:, None] - others, axis=2).min(axis=1)


def ringed(mesh, lethal, ring=RING):
    """(V,) costs: inf at these vertices, over the limit within a ring around them, 0 elsewhere."""
    points = mesh.vertices[:, :2].astype(np.float64)
    costs = np.where(gaps(points, points[lethal]) <= ring, OVER, 0.0)
    costs[lethal] = np.inf
    return costs.astype(np.float32)


def cluttered(mesh, seed, posts=12):
    """Costs around a wall and some posts, none of them near the goal."""
    random = np.random.default_rng(seed)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    lethal = (np.abs(x - 4.0) < 0.12) & (y < 5.0)
    lethal[random.choice(len(x), posts, replace=False)] = True
    lethal[np.hypot(x - GOAL[0], y - GOAL[1]) < 2 * RING] = False
    return ringed(mesh, lethal)


def starts_on(mesh, costs, count, seed):
    """Points of which the nearest corner of their face is over the limit, but not lethal."""
    random, found = np.random.default_rng(seed), []
    while len(found) < count:
        face = int(random.integers(len(mesh.faces)))
        point = random.dirichlet([1, 1, 1]) @ mesh.vertices[mesh.faces[face]].astype(np.float64)
        corners = mesh.faces[face].astype(int)
        nearest = corners[np.argmin(np.linalg.norm(mesh.vertices[corners] - point, axis=1))]
        if costs[nearest] == OVER:
            found.append(point)
    return found


def ground_along(mesh_map, poses):
    """The corners with the largest weights at points all along a path."""
    points = poses[:, :3]
    shares = np.linspace(0.0, 1.0, 21)[:-1, None]
    along = [a + shares * (b - a) for a, b in zip(points, points[1:])]
    along = np.concatenate(along + [points[-1:]])
    carried = mesh_map.queries.carry(along, max_distance=0.01)
    return mesh_map.faces[carried.faces, carried.barycentric.argmax(axis=1)]


def along_edges(mesh_map, costs, start):
    """m, from a point over edges between vertices that are not lethal to the nearest open one."""
    edges = mesh_map.topology.edges.astype(int)
    edges = edges[np.isfinite(costs[edges]).all(axis=1)]
    ends = mesh_map.vertices[edges].astype(np.float64)
    lengths = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    count = len(costs)
    graph = csr_matrix((lengths, edges.T), shape=(count, count))
    face = mesh_map.closest_face(start, 0.1).face
    corners = mesh_map.faces[face].astype(int)
    corners = corners[np.isfinite(costs[corners])]
    first = np.linalg.norm(mesh_map.vertices[corners] - start, axis=1)
    found = first[:, None] + dijkstra(graph, directed=False, indices=corners)
    return found[:, costs <= 1.0].min()


@EACH_PLANNER
@pytest.mark.parametrize("mesh, seed", [(GRID, 0), (FINE, 1)], ids=["grid", "jittered"])
def test_forty_starts_of_forty(cls, mesh, seed):
    costs = cluttered(mesh, seed)
    mesh_map = MapWithCosts(mesh, costs)
    planner, goal = planner_on(mesh_map, cls), Pose.at(GOAL)
    open_points = mesh.vertices[costs == 0].astype(np.float64)
    straight_ones = 0
    for start in starts_on(mesh, costs, 40, seed):
        result = planner.make_plan(Pose.at(start), goal)
        assert result.succeeded, result.message
        assert "it begins on closed ground" in result.message
        assert np.allclose(result.poses[[0, -1], :3], [start, goal.position], atol=1e-5)
        ground = costs[ground_along(mesh_map, result.poses)]
        assert np.isfinite(ground).all()
        left = int(np.argmax(ground == 0))
        assert (ground[:left] == OVER).all() and (ground[left:] == 0).all()
        lead = result.plan_field.lead
        assert f"which it leaves after {lead:.2f} m" in result.message
        straight = np.linalg.norm(open_points - start, axis=1)
        assert straight.min() - 1e-6 <= lead <= along_edges(mesh_map, costs, start) + 1e-6
        # A straight way to open ground is the shortest where it is a way.
        nearest = open_points[np.argmin(straight)]
        way = start + np.linspace(0.0, 1.0, 50)[:, None] * (nearest - start)
        if gaps(way[:, :2], mesh.vertices[np.isinf(costs), :2]).min() > 0.3:
            straight_ones += 1
            assert lead <= straight.min() * 1.005 + 1e-6
        # The path's beginning is as long: it is one straight piece after the other.
        steps = np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1)
        travelled = np.append(0.0, np.cumsum(steps))
        assert np.abs(travelled - lead).min() < 1e-3
    assert straight_ones >= 5


@EACH_PLANNER
def test_no_way_leads_through_lethal_ground(cls):
    """Open ground is 0.3 m away behind a wall, and 1.2 m away on the other side."""
    wall = np.abs(X - 4.0) < 0.06
    costs = np.where((X < 4.0) & (X > 2.75), OVER, 0.0)
    costs[wall] = np.inf
    mesh_map, start = MapWithCosts(GRID, costs), [3.85, 4.03, 0.0]
    result = planner_on(mesh_map, cls).make_plan(Pose.at(start), Pose.at([1.0, 4.0, 0.0]))
    assert result.succeeded and result.plan_field.lead == pytest.approx(3.85 - 2.7, abs=0.02)
    other = planner_on(mesh_map, cls).make_plan(Pose.at(start), Pose.at([7.0, 4.0, 0.0]))
    assert other.outcome == Outcome.NO_PATH_FOUND


@EACH_PLANNER
@pytest.mark.parametrize("cost", [np.inf, np.nan])
def test_a_start_that_is_lethal_or_unknown_itself_has_no_way_out(cls, cost):
    costs = np.where(np.hypot(X - 4.0, Y - 4.0) < 0.5, OVER, 0.0)
    costs[np.hypot(X - 4.0, Y - 4.0) < 0.02] = cost
    result = planner_on(MapWithCosts(GRID, costs), cls).make_plan(
        Pose.at([4.03, 4.01, 0.0]), Pose.at([7.0, 7.0, 0.0])
    )
    assert result.outcome == Outcome.INVALID_START
    assert ("lethal" if cost == np.inf else "unknown") in result.message


@EACH_PLANNER
def test_closed_ground_without_a_way_out(cls):
    costs = np.where(np.hypot(X - 4.0, Y - 4.0) < 1.0, OVER, 0.0)
    costs[np.abs(np.hypot(X - 4.0, Y - 4.0) - 1.0) < 0.12] = np.inf
    result = planner_on(MapWithCosts(GRID, costs), cls).make_plan(
        Pose.at([4.03, 4.01, 0.0]), Pose.at([7.0, 7.0, 0.0])
    )
    assert result.outcome == Outcome.INVALID_START
    assert "of cost 2, over the cost limit 1" in result.message
    assert "no ground can be reached that may be passed" in result.message
    # The map's cost is told, whatever the body makes of it.
    result = body_planner(MapWithCosts(GRID, costs), cls, 1.0).make_plan(
        Pose.at([4.03, 4.01, 0.0]), Pose.at([7.0, 7.0, 0.0])
    )
    assert result.outcome == Outcome.INVALID_START and "of cost 2, over" in result.message


@EACH_PLANNER
@pytest.mark.parametrize("tolerance", [0.0, 1.0])
def test_open_ground_that_does_not_go_on_is_no_way_out(cls, tolerance):
    """An island of open ground in the ring is nearer than the ground with the goal."""
    costs = np.where(X < 4.0, OVER, 0.0)
    island = np.hypot(X - 2.5, Y - 4.0) < 0.25
    costs[island] = 0.0
    costs[np.hypot(X - 7.0, Y - 4.0) < 0.2] = np.inf
    goal = [7.0, 4.02, 0.0] if tolerance else [6.0, 4.0, 0.0]
    mesh_map = MapWithCosts(GRID, costs)
    result = planner_on(mesh_map, cls).make_plan(
        Pose.at([3.03, 4.02, 0.0]), Pose.at(goal), tolerance
    )
    assert result.succeeded, result.message
    assert result.plan_field.lead == pytest.approx(4.0 - 3.03, abs=0.01)
    ground = costs[ground_along(mesh_map, result.poses)]
    assert (ground[int(np.argmax(ground == 0)) :] == 0).all()


@EACH_PLANNER
def test_a_goal_on_closed_ground(cls):
    """As in Move Base Flex and Nav2: refused, or replaced by the nearest open place within the
    tolerance."""
    wall = np.abs(X - 6.0) < 0.06
    costs = ringed(GRID, wall)  # closed from x = 5.5 on, open up to 5.4
    mesh_map = MapWithCosts(GRID, costs)
    for start in ([1.03, 4.02, 0.0], [5.73, 1.02, 0.0]):
        goal = [5.73, 4.52, 0.0]
        result = planner_on(mesh_map, cls).make_plan(Pose.at(start), Pose.at(goal))
        assert result.outcome == Outcome.INVALID_GOAL
        result = planner_on(mesh_map, cls).make_plan(Pose.at(start), Pose.at(goal), 0.2)
        assert result.outcome == Outcome.INVALID_GOAL
        result = planner_on(mesh_map, cls).make_plan(Pose.at(start), Pose.at(goal), 0.6)
        assert result.succeeded, result.message
        assert result.poses[-1, :3] == pytest.approx([5.4, 4.52, 0.0], abs=1e-4)
        assert "it ends 0.33 m from the goal (tolerance 0.60 m)" in result.message
        ground = costs[ground_along(mesh_map, result.poses)]
        left = int(np.argmax(ground == 0))
        assert (ground[:left] == OVER).all() and (ground[left:] == 0).all()


def body_planner(mesh_map, cls, radius):
    planner = cls()
    planner.body = Body(mesh_map.geometry, RobotShape(radius=radius))
    assert planner.initialize("planner", mesh_map, {}) == []
    return planner


@EACH_PLANNER
def test_the_body_is_not_led_nearer_to_what_is_lethal(cls):
    """The shortest way out of a corridor comes by a post; there is room on the other side."""
    lethal = (X > 4.0) & ((np.abs(Y - 3.0) < 0.04) | (np.abs(Y - 4.1) < 0.04) | (X > 5.96))
    costs = np.where(lethal | (np.hypot(X - 4.5, Y - 3.3) < 0.04), np.inf, 0.0)
    start, points = np.array([5.03, 3.32, 0.0]), XY[np.isinf(costs)]
    planner = body_planner(MapWithCosts(GRID, costs), cls, 0.6)
    result = planner.make_plan(Pose.at(start), Pose.at([1.0, 5.0, 0.0]))
    assert result.succeeded, result.message
    begin = gaps(start[None, :2], points)[0]
    shares = np.linspace(0.0, 1.0, 21)[:, None, None]
    along = (result.poses[:-1, :2] + shares * np.diff(result.poses[:, :2], axis=0)).reshape(-1, 2)
    assert begin < 0.35 and gaps(along, points).min() > begin - 0.03


def test_edges_that_costs_make_longer():
    """The planner over edges adds the length of the lead, whatever edges weigh."""
    costs = ringed(GRID, np.abs(X - 6.0) < 0.06)
    planner = planner_on(MapWithCosts(GRID, costs), DijkstraMeshPlanner)
    result = planner.make_plan(Pose.at([5.73, 4.02, 0.0]), Pose.at([2.0, 4.0, 0.0]))
    steps = np.linalg.norm(np.diff(result.poses[:, :3], axis=0), axis=1)
    assert result.cost == pytest.approx(steps.sum(), rel=1e-5)
