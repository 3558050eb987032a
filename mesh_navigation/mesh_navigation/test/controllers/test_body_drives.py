"""The controller keeps the robot's body off lethal ground, whatever the path."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.controllers.mesh_controller import MeshController
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.plugins.controller import ControlFailure
from mesh_navigation.plugins.planner import PlanResult
from mesh_navigation.simulation.driving import drive
from controller_drives import command_at, planned
from navigation_test_maps import MapWithCosts

GRID = zoo.grid(cells=80, size=8.0)
X, Y, _ = GRID.vertices.T
ROUND = RobotShape(radius=0.3)
LONG = RobotShape([[0.6, 0.2], [-0.6, 0.2], [-0.6, -0.2], [0.6, -0.2]])
SLACK = 0.02  # m


def at(pose):
    """(V,): a post at a point."""
    return np.where(np.hypot(X - pose[0], Y - pose[1]) < 0.04, np.inf, 0.0)


def controller_of(mesh_map, shape, **parameters):
    controller = MeshController()
    controller.body = Body(mesh_map.geometry, shape)
    assert controller.initialize("controller", mesh_map, parameters) == []
    return controller


def following(mesh_map, plan, shape, **parameters):
    controller = controller_of(mesh_map, shape, **parameters)
    controller.set_plan(plan)
    return controller


def failure(controller, pose):
    with pytest.raises(ControlFailure) as info:
        command_at(controller, pose)
    return info.value


def driven(costs, shape, start, goal, planner_shape=None, given={}, **body):
    """A drive; the planner knows another shape only where one is given."""
    mesh_map = MapWithCosts(GRID, costs)
    planner = make_planner(mesh_map, body=Body(mesh_map.geometry, planner_shape or RobotShape()))
    controller = controller_of(mesh_map, shape, **given)
    return drive(mesh_map, planner, controller, start=start, goal=goal, max_time=120.0, **body)


def depth(track, costs, shape):
    """m: how far the shape has come over a lethal vertex, in all of a track."""
    lethal = GRID.vertices[np.isposinf(costs)].astype(np.float64)
    poses = [Pose(row[:3], row[3:]) for row in track]
    headings = np.array([pose.heading for pose in poses])
    lefts = np.stack([-headings[:, 1], headings[:, 0]], axis=1)
    offsets = lethal[None, :, :2] - track[:, None, :2]
    local = [np.einsum("tpi,ti->tp", offsets, axis) for axis in (headings[:, :2], lefts)]
    return float(shape.depths(np.stack(local, axis=-1)).max())


def test_a_path_of_a_point_past_a_post_is_not_driven_by_a_round_robot():
    costs = at([4.0, 4.2])
    start, goal = Pose.at([2.0, 4.0, 0.0]), Pose.at([6.0, 4.0, 0.0])
    assert driven(costs, RobotShape(), start, goal).arrived
    went = driven(costs, ROUND, start, goal)
    assert not went.arrived and "blocked after" in went.result.message
    assert depth(went.track, costs, ROUND) < 0.0


@pytest.mark.parametrize("seed", range(2))
def test_random_posts(seed):
    """Plans of the round robot are driven, and the radius is kept, with slip and noise."""
    random = np.random.default_rng(seed)
    costs = np.zeros(len(GRID.vertices))
    costs[random.choice(len(costs), 25, replace=False)] = np.inf
    costs[np.hypot(X - 1.0, Y - 1.0) < 0.8] = costs[np.hypot(X - 7.0, Y - 7.0) < 0.8] = 0.0
    went = driven(
        costs,
        ROUND,
        Pose.at([1.0, 1.0, 0.0], random.uniform(-3.0, 3.0)),
        Pose.at([7.0, 7.0, 0.0]),
        planner_shape=ROUND,
        seed=seed,
        slip=0.05,
        noise=0.02,
    )
    assert went.arrived, went.result.message
    assert depth(went.track, costs, ROUND) < SLACK


def corner(width):
    """(V,): an L-shaped corridor of this width (m) from (1, 2) over (5, 2) to (5, 6)."""
    along = (np.abs(Y - 2.0) < width / 2) & (X < 5.0 + width / 2)
    up = (np.abs(X - 5.0) < width / 2) & (Y > 2.0 - width / 2)
    return np.where(along | up, 0.0, np.inf)


@pytest.mark.parametrize("width, arrives", [(2.0, True), (0.55, False)])
def test_a_long_footprint_in_a_curve(width, arrives):
    costs = corner(width)
    start, goal = Pose.at([1.5, 2.0, 0.0]), Pose.at([5.0, 6.0, 0.0], np.pi / 2)
    went = driven(costs, LONG, start, goal, planner_shape=LONG)
    assert went.arrived == arrives, went.result.message
    assert depth(went.track, costs, LONG) < SLACK
    assert depth(went.track, costs, RobotShape(radius=0.2)) < SLACK
    if not arrives:
        assert "footprint" in went.result.message, went.result.message


def test_an_arc_under_whose_sweep_a_post_is_is_not_sent():
    """The middle stays far from it; only the outer side of the turn would touch it."""
    here, goal = Pose.at([4.0, 4.07, 0.0]), Pose.at([4.3, 5.07, 0.0])
    free = MapWithCosts(GRID)
    plan = planned(free, here, goal)
    turns = command_at(following(free, plan, LONG), here).velocity
    assert turns.yaw > 0.0
    post = at([4.5, 4.3])
    touched = failure(following(MapWithCosts(GRID, post), plan, LONG), here)
    assert touched.outcome == ExePathOutcome.BLOCKED_PATH
    assert "footprint would touch" in touched.message
    assert command_at(following(MapWithCosts(GRID, post), plan, ROUND), here).outcome == 0
    # What is under it already does not hold it, as long as it goes away from there.
    under = MapWithCosts(GRID, at([3.5, 4.0]))
    straight = planned(free, here, Pose.at([6.0, 4.07, 0.0]))
    assert command_at(following(under, straight, LONG), here).velocity.x > 0.0


WALL, POST = np.where((X < 4.5) & (Y > 4.5), np.inf, 0.0), at([4.6, 4.3])


@pytest.mark.parametrize(
    "shape, costs, clearance, lookahead",
    [(ROUND, WALL, 0.2, 1.5), (RobotShape(), POST, 0.28, 2.5)],
    ids=["round", "point"],
)
def test_side_clearance_is_kept_where_the_plan_has_it(shape, costs, clearance, lookahead):
    """Around the corner of a path that is far enough from what is in it; it would be cut."""
    points = np.array([[2.0, 4.0, 0.0], [5.0, 4.0, 0.0], [5.0, 7.0, 0.0]])
    poses = np.concatenate(
        [np.linspace(a, b, 16)[1:] for a, b in zip(points, points[1:])] + [points[-1:]]
    )
    poses = np.pad(poses, ((0, 0), (0, 4)))
    poses[:, 6] = 1.0
    least = []
    for kept in (0.0, clearance):
        mesh_map = MapWithCosts(GRID, costs)
        parameters = {"side_clearance": kept, "lookahead_distance": lookahead, "max_angle": 60.0}
        controller = controller_of(mesh_map, shape, **parameters, turn_to_goal_heading=False)
        planner = _Path(poses)
        start, goal = Pose.at(points[0]), Pose.at(points[-1])
        went = drive(mesh_map, planner, controller, start=start, goal=goal, max_time=60.0)
        assert went.arrived, went.result.message
        least.append(-depth(went.track, costs, shape))
    assert least[0] < clearance - SLACK <= least[1], least


class _Path:
    """A planner that has one path, without a field."""

    def __init__(self, poses):
        self.poses = poses

    def make_plan(self, start, goal, cancellation=None):
        return PlanResult(0, "", self.poses)


def slope(floor):
    """(V,): costs that fall from 4 at x = 3 to 2 at x = 4, and floor beyond."""
    return np.where(X < 3.95, 4.0 - 2.0 * np.clip(X - 3.0, 0.0, 1.0), floor)


def test_ground_over_the_cost_limit_is_left_and_not_entered():
    here, goal = Pose.at([3.3, 4.0, 0.0]), Pose.at([6.0, 4.0, 0.0])
    plan = planned(MapWithCosts(GRID), here, goal)
    inside = MapWithCosts(GRID, slope(0.0))
    assert command_at(following(inside, plan, RobotShape()), here).velocity.x > 0.0
    rising = MapWithCosts(GRID, np.where(X < 3.95, 2.0 + 2.0 * np.clip(X - 3.0, 0.0, 1.0), 0.0))
    assert (
        failure(following(rising, plan, RobotShape()), here).outcome == ExePathOutcome.BLOCKED_PATH
    )
    level = MapWithCosts(GRID, slope(2.0))
    assert (
        failure(following(level, plan, RobotShape()), Pose.at([4.5, 4.0, 0.0])).outcome
        == ExePathOutcome.BLOCKED_PATH
    )
    before = Pose.at([3.4, 4.0, 0.0])
    ahead = MapWithCosts(GRID, np.where(np.abs(X - 3.8) < 0.2, 2.0, 0.0))
    found = failure(following(ahead, plan, RobotShape()), before)
    assert found.outcome == ExePathOutcome.BLOCKED_PATH and "blocked after 0.2" in found.message
    limit = following(ahead, plan, RobotShape(), cost_limit=2.5)
    assert command_at(limit, before).velocity.x > 0.0


def test_a_robot_that_stands_too_near_to_a_wall_leaves_it():
    costs = np.where(X > 5.0, np.inf, 0.0)
    start, goal = Pose.at([4.85, 2.0, 0.0], np.pi), Pose.at([2.0, 4.0, 0.0])
    went = driven(costs, ROUND, start, goal, planner_shape=ROUND)
    assert went.arrived, went.result.message
    gaps = 5.05 - went.track[:, 0]
    assert gaps.min() > gaps[0] - SLACK
