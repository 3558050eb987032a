"""Whole drives: planned, controlled, simulated and measured."""

import math

import numpy as np
import pytest

from mesh_map.base.errors import MeshMapError
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_navigation.base.outcomes import ExePathOutcome, GetPathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import Velocity
from mesh_navigation.plugins.controller import Command, ControlFailure, MeshController
from mesh_navigation.simulation.driving import clearances, drive, make_controller
from mesh_navigation.simulation.simulated_robot import SimulatedRobot
from mesh_navigation.simulation.surface_robot import SurfaceRobot
from navigation_test_maps import MapWithCosts, planner_on, vertex_at

GRID = zoo.grid()
PLANE = MeshMap(GRID.vertices, GRID.faces)
START, GOAL = Pose.at((2, 2, 0)), Pose.at((8, 7, 0))


class Straight(MeshController):
    """Goes for the goal, whatever is in between."""

    def set_plan(self, plan):
        self.plan = plan

    def is_goal_reached(self, state, dist_tolerance, angle_tolerance):
        return np.linalg.norm(state.pose.position - self.plan.goal.position) < dist_tolerance

    def compute_velocity(self, state, cancellation):
        way = self.plan.goal.position - state.pose.position
        ahead = state.pose.heading
        angle = math.atan2(ahead[0] * way[1] - ahead[1] * way[0], ahead @ way)
        return Command(
            0, "", Velocity(0.5 if abs(angle) < 0.5 else 0.0, 0.0, np.clip(angle, -1, 1))
        )


def straight_on(mesh_map):
    controller = Straight()
    controller.initialize("straight", mesh_map)
    return controller


def test_a_drive_is_measured():
    went = drive(PLANE, "exact", straight_on(PLANE), start=START, goal=GOAL)
    assert went.arrived and went.result.outcome == ExePathOutcome.SUCCESS
    assert went.result.dist_to_goal < 0.1
    assert went.planned_length == pytest.approx(math.hypot(6, 5), abs=1e-4)
    steps = np.linalg.norm(np.diff(went.track[:, :3], axis=0), axis=1)
    assert went.driven_length == pytest.approx(steps.sum(), rel=1e-6)
    assert went.track[0, :3].tolist() == [2, 2, 0]
    assert went.track[-1, :3] == pytest.approx(went.result.final_pose.position)
    assert went.times[0] == 0 and (np.diff(went.times) > 0).all()
    assert (np.diff(went.times) < 0.0201).all()
    count = len(went.times)
    assert went.track.shape == (count, 7) and went.faces.shape == (count,)
    assert went.commands.shape == went.velocities.shape == (count, 3)
    for index in range(0, count, 50):
        corners = GRID.vertices[GRID.faces[went.faces[index]]]
        assert (corners.min(axis=0) - 1e-6 <= went.track[index, :3]).all()
        assert (went.track[index, :3] <= corners.max(axis=0) + 1e-6).all()
    # 20 cycles in a second, each with its command.
    assert len(went.cycles) == pytest.approx(20 * went.times[-1], abs=2)
    assert set(map(tuple, went.commands)) == {(0, 0, 0)} | {
        tuple(cycle.velocity) for cycle in went.cycles[:-1]
    }
    assert (went.clearance, went.blocked.tolist()) == (math.inf, [])


def test_drives_over_lethal_ground_are_seen():
    costs = np.zeros(len(GRID.vertices))
    lethal = vertex_at(GRID, (5, 4.5, 0))
    costs[lethal] = math.inf
    mesh_map = MapWithCosts(GRID, costs)
    went = drive(mesh_map, "wave_front", straight_on(mesh_map), start=START, goal=GOAL)
    assert went.arrived
    distances = np.linalg.norm(went.track[:, :3] - GRID.vertices[lethal], axis=1)
    assert went.clearance == pytest.approx(distances.min(), abs=1e-9)
    places = PLANE.spatial_index.closest_batch(points=went.track[:, :3])
    corners = GRID.faces[places.faces, np.argmax(places.barycentric, axis=1)]
    assert went.blocked.tolist() == np.flatnonzero(corners == lethal).tolist()
    assert len(went.blocked) > 10


def test_clearances_are_distances_to_what_is_lethal_or_unknown():
    random = np.random.default_rng(0)
    costs = random.choice(
        [0.0, 5.0, math.inf, math.nan], len(GRID.vertices), p=[0.8, 0.1, 0.05, 0.05]
    )
    points = random.uniform(-1, 11, (100, 3))
    blocked = GRID.vertices[~np.isfinite(costs)].astype(np.float64)
    expected = np.linalg.norm(points[:, None] - blocked, axis=2).min(axis=1)
    assert clearances(MapWithCosts(GRID, costs), points) == pytest.approx(expected, abs=1e-9)


def test_the_same_seed_makes_the_same_drive():
    def track(seed):
        robot = dict(seed=seed, slip=0.1, noise=0.05)
        return drive(PLANE, "wave_front", straight_on(PLANE), start=START, goal=GOAL, **robot).track

    assert track(1).tolist() == track(1).tolist()
    assert track(1).shape != track(2).shape or (track(1) != track(2)).any()


def test_a_plan_that_fails_is_the_result():
    went = drive(PLANE, "wave_front", straight_on(PLANE), start=START, goal=Pose.at((50, 5, 0)))
    assert went.result.outcome == GetPathOutcome.INVALID_GOAL
    assert not went.arrived and went.driven_length == 0 and len(went.times) == 1


def test_a_controller_that_fails_is_the_result():
    class Lost(Straight):
        def compute_velocity(self, state, cancellation):
            raise ControlFailure(ExePathOutcome.INVALID_PATH, "nothing to follow")

    controller = Lost()
    controller.initialize("lost", PLANE)
    went = drive(PLANE, "wave_front", controller, start=START, goal=GOAL)
    assert went.result.outcome == ExePathOutcome.INVALID_PATH
    assert went.result.message == "nothing to follow"


def test_time_is_limited():
    went = drive(PLANE, "wave_front", straight_on(PLANE), start=START, goal=GOAL, max_time=2.0)
    assert went.result.outcome == ExePathOutcome.CANCELED
    assert "2.0 s of simulated time are over" in went.result.message
    assert went.times[-1] == pytest.approx(2.0, abs=0.03)
    assert went.commands[-1].tolist() != [0, 0, 0]  # it was driving


def test_pushes_and_a_robot_of_ones_own():
    robot = SimulatedRobot(SurfaceRobot(PLANE, GOAL), pose_noise=0.01)
    pushed = []

    def push(time, pushed_robot):
        assert pushed_robot is robot
        if time > 3 and not pushed:
            pushed.append(time)
            robot.put(Pose.at((9, 1, 0)))

    went = drive(
        PLANE, "exact", straight_on(PLANE), start=START, goal=GOAL, robot=robot, on_step=push
    )
    assert went.arrived
    steps = np.linalg.norm(np.diff(went.track[:, :3], axis=0), axis=1)
    assert steps.max() > 1
    assert went.driven_length == pytest.approx(steps.sum() - steps.max(), rel=0.01)
    again = drive(PLANE, "exact", straight_on(PLANE), start=START, goal=GOAL, robot=robot)
    assert again.times[0] == 0
    assert again.driven_length == pytest.approx(7.8, abs=0.3)
    with pytest.raises(MeshMapError, match="slip: not for a robot of one's own"):
        drive(PLANE, "exact", straight_on(PLANE), start=START, goal=GOAL, robot=robot, slip=0.1)


def test_it_is_planned_anew_while_it_drives():
    controller = straight_on(PLANE)
    plans = []
    planner = planner_on(PLANE)

    class Counting(type(planner)):
        def plan(self, *arguments):
            plans.append(arguments[0].position)
            return super().plan(*arguments)

    counting = Counting()
    counting.initialize("counting", PLANE)
    values = {"planner_frequency": 2.0, "dist_tolerance": 0.05}
    went = drive(PLANE, counting, controller, start=START, goal=GOAL, values=values)
    assert went.arrived and went.result.dist_to_goal < 0.05
    assert len(plans) == 1 + math.floor(went.times[-1] * 2)
    assert np.diff(np.array(plans)[:, 0]).min() >= 0  # each from where the robot was then


@pytest.mark.parametrize(
    "controller, parameters, text",
    [
        ("nobody/NoController", {}, "there is no mesh_navigation::MeshController of the type"),
        ("mesh_controller/MeshController", {"speeed": 1}, "has no parameter 'speeed'"),
    ],
)
def test_controllers_that_cannot_be_used_are_refused(controller, parameters, text):
    with pytest.raises(MeshMapError, match=text):
        make_controller(PLANE, controller, parameters)


def test_parameters_that_cannot_be_used_are_refused():
    with pytest.raises(MeshMapError, match="parameter dist_tolerance is 'near'"):
        drive(PLANE, start=START, goal=GOAL, values={"dist_tolerance": "near"})


@pytest.mark.parametrize("seed", range(6))
def test_the_robot_arrives(seed):
    random = np.random.default_rng(seed)
    ends = [Pose.at((*random.uniform(0.5, 9.5, 2), 0), random.uniform(-3, 3)) for _ in range(2)]
    went = drive(PLANE, start=ends[0], goal=ends[1], seed=seed, slip=0.1, noise=0.02)
    assert went.arrived, went.result.message
    assert went.result.dist_to_goal < 0.1 and went.result.angle_to_goal < math.pi / 18
    assert went.driven_length < 1.5 * went.planned_length + 1
