"""A robot that stands on ground over the cost limit, or too near to something, gets out and
arrives, and never touches what is lethal."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_map.distance.obstacle_distance import ObstacleDistance, SurfaceFront
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.body.body import Body
from mesh_navigation.body.robot_shape import RobotShape
from mesh_navigation.controllers.mesh_controller import MeshController
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.plugins.controller import ControlFailure
from mesh_navigation.simulation.driving import drive
from controller_drives import command_at, planned
from navigation_test_maps import MapWithCosts

GRID = zoo.grid(cells=80, size=8.0)
X, Y, _ = GRID.vertices.T
OVER = 2.0


class RingedMap(MapWithCosts):
    """Costs over the limit within a radius around what is lethal, as an inflation layer has it,
    fading beyond, and those of the ground itself."""

    def __init__(self, lethal, radius, ground=0.0):
        super().__init__(GRID)
        self.radius, self.ground = radius, ground
        self.obstacles = ObstacleDistance(
            front=SurfaceFront.of(self.geometry), max_distance=2.0 * radius
        )
        self.see(lethal)

    def see(self, lethal):
        self.obstacles.compute(lethal)
        distances = self.obstacles.distances()
        fading = 0.5 * OVER * np.clip(2.0 - distances / self.radius, 0.0, 1.0)
        ring = np.where(distances <= self.radius, OVER, 0.5 * fading)
        self.costs = np.float32(np.where(lethal, np.inf, ring + self.ground))

    def planning_costs(self):
        planning = getattr(self, "_planning", None)
        if planning is None or planning.costs is not self.costs:
            self._planning = super().planning_costs()
            self.costs = self._planning.costs
        return self._planning


def robot_on(mesh_map, shape, planner="wave_front", given={}):
    """A planner and a controller of one body."""
    body, controller = Body(mesh_map.geometry, shape), MeshController()
    controller.body = body
    assert controller.initialize("controller", mesh_map, given) == []
    return make_planner(mesh_map, planner, body=body), controller


def check_drive(went, mesh_map, shape):
    """It has arrived, has never been on lethal ground, and its body has not come nearer to that
    than it was."""
    assert went.arrived, went.result.message
    assert not len(went.blocked)
    lethal = GRID.vertices[np.isposinf(mesh_map.costs)]
    gaps = [np.linalg.norm(lethal - place, axis=1).min() for place in went.track[:, :3]]
    assert min(gaps) > min(gaps[0], shape.inscribed_radius) - 0.03


def on_closed_ground(mesh_map, places):
    """(N,) bool: whether the corner with the largest weight is over the limit."""
    carried = mesh_map.queries.carry(places, max_distance=0.1)
    corners = mesh_map.faces[carried.faces, carried.barycentric.argmax(axis=1)]
    return mesh_map.costs[corners] > 1.0


def cluttered(seed, posts=10):
    """(V,) bool: a wall and posts, none of them near the goal at (7, 7)."""
    random = np.random.default_rng(seed)
    lethal = (np.abs(X - 4.0) < 0.12) & (Y < 4.5)
    lethal[random.choice(len(X), posts, replace=False)] = True
    return lethal & (np.hypot(X - 7.0, Y - 7.0) > 1.2)


GROUNDS = {"level": 0.0, "uneven": 0.2 + 0.2 * np.sin(5.0 * X) * np.cos(4.0 * Y)}
SHAPES = {"point": RobotShape(), "round": RobotShape(radius=0.25)}


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("planner", ["wave_front", "dijkstra", "exact"])
def test_starts_in_a_ring(planner, shape, ground):
    """The ring is 0.7 m wide: costs do not fall for longer than a way may be without a plan."""
    mesh_map, shape = RingedMap(cluttered(0), 0.7, GROUNDS[ground]), SHAPES[shape]
    random = np.random.default_rng(3)
    for number in range(4):
        while True:
            start = np.append(random.uniform(0.5, 7.5, 2), 0.0)
            gap = np.linalg.norm(GRID.vertices[np.isinf(mesh_map.costs)] - start, axis=1).min()
            if on_closed_ground(mesh_map, start[None])[0] and 0.1 < gap < 0.6:
                break
        went = drive(
            mesh_map,
            *robot_on(mesh_map, shape, planner),
            start=Pose.at(start, random.uniform(-np.pi, np.pi)),
            goal=Pose.at([7.0, 7.0, 0.0]),
            seed=number,
            slip=0.05,
            max_time=120.0,
        )
        check_drive(went, mesh_map, shape)
        assert went.plan.plan_field.lead > 0.0
        # Once it is out, it keeps out; wheels that slip may bring it a little back at first.
        closed = np.flatnonzero(on_closed_ground(mesh_map, went.track[:, :3]))
        far = np.linalg.norm(went.track[:, :3] - start, axis=1) > went.plan.plan_field.lead + 0.3
        assert not far[closed].any()


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("length", [0.08, 1.2], ids=["post", "wall"])
@pytest.mark.parametrize("shape", SHAPES)
def test_an_obstacle_is_seen_beside_the_robot(shape, length, side):
    """0.25 m beside it, while it drives: with new plans it goes on, and no behavior has to help."""
    shape = SHAPES[shape]
    nothing = np.zeros(len(X), np.bool_)
    mesh_map, seen = RingedMap(nothing, 0.7), []

    def on_step(time, robot):
        place = robot.body.place.position
        if not seen and place[0] > 3.0:
            seen.append(place)
            beside = np.abs(Y - place[1] - side * 0.3) < 0.08
            mesh_map.see(beside & (X > place[0] - 0.08) & (X < place[0] + length))
            lethal = GRID.vertices[np.isinf(mesh_map.costs)]
            assert 0.2 < np.linalg.norm(lethal - place, axis=1).min() < 0.28
            assert on_closed_ground(mesh_map, place[None])[0]

    went = drive(
        mesh_map,
        *robot_on(mesh_map, shape),
        start=Pose.at([1.0, 4.03, 0.0]),
        goal=Pose.at([7.0, 4.03, 0.0]),
        values={"planner_frequency": 1.0},
        max_time=60.0,
        on_step=on_step,
    )
    assert seen and went.arrived, went.result.message
    assert not len(went.blocked)
    lethal = GRID.vertices[np.isinf(mesh_map.costs)]
    gaps = [np.linalg.norm(lethal - place, axis=1).min() for place in went.track[:, :3]]
    assert min(gaps) > 0.2


@pytest.mark.parametrize("planner", ["wave_front", "dijkstra"])
def test_out_of_a_corridor_that_is_too_narrow(planner):
    """Around a post, where it is as near to the other wall as it was to the first one."""
    lethal = (X > 4.0) & ((np.abs(Y - 3.0) < 0.04) | (np.abs(Y - 4.1) < 0.04) | (X > 5.96))
    mesh_map = MapWithCosts(
        GRID, np.where(lethal | (np.hypot(X - 4.5, Y - 3.3) < 0.04), np.inf, 0.0)
    )
    shape = RobotShape(radius=0.6)
    went = drive(
        mesh_map,
        *robot_on(mesh_map, shape, planner),
        start=Pose.at([5.03, 3.32, 0.0], 2.0),
        goal=Pose.at([1.5, 5.0, 0.0]),
        max_time=120.0,
    )
    check_drive(went, mesh_map, shape)


def test_only_the_plan_knows_the_way_out():
    """A way that the planner did not know to lead over closed ground is not driven, nor is lethal
    ground on a way out."""
    here, goal = Pose.at([3.3, 4.0, 0.0]), Pose.at([6.0, 4.0, 0.0])
    level = MapWithCosts(GRID, np.where((X < 4.25), OVER, 0.0))
    controller = MeshController()
    assert controller.initialize("controller", level, {}) == []
    controller.set_plan(planned(MapWithCosts(GRID), here, goal))
    with pytest.raises(ControlFailure) as info:
        command_at(controller, here)
    assert info.value.outcome == ExePathOutcome.BLOCKED_PATH
    plan = planned(level, here, goal)
    assert plan.field.lead == pytest.approx(1.0, abs=0.01)
    controller.set_plan(plan)
    assert command_at(controller, here).velocity.x > 0.0
    level.costs[np.abs(X - 3.6) < 0.06] = np.inf
    with pytest.raises(ControlFailure) as info:
        command_at(controller, here)
    assert info.value.outcome == ExePathOutcome.BLOCKED_PATH
    # Behind the way out it is as before: what costs too much is not entered.
    level.costs = np.float32(np.where(X < 4.25, OVER, 0.0))
    level.costs[np.abs(X - 4.8) < 0.06] = OVER
    with pytest.raises(ControlFailure) as info:
        command_at(controller, Pose.at([4.55, 4.0, 0.0]))
    assert info.value.outcome == ExePathOutcome.BLOCKED_PATH
