"""The mesh controller with paths of other programs, fast robots, slow cycles, tiny tolerances."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, RobotState
from mesh_navigation.execution.path_execution import PathExecution, Tolerances
from mesh_navigation.plugins.controller import ControllerPlan
from mesh_navigation.simulation.driving import drive
from mesh_navigation.simulation.simulated_robot import SimulatedClock, SimulatedRobot
from mesh_navigation.simulation.surface_robot import SurfaceRobot
from mesh_navigation.simulation.wheels import BaseLimits
from controller_drives import command_at, controller_on, following
from navigation_test_maps import MapWithCosts

PLANE = MapWithCosts(zoo.grid(cells=50))
STRONG = BaseLimits(speed=6.0, acceleration=20.0)


def path_through(corners, spacing):
    """A plan without a field: points on straight ways between corners, headings along them."""
    corners = np.array(corners, float)
    points = [
        np.linspace(a, b, max(int(np.linalg.norm(b - a) / spacing), 1), endpoint=False)
        for a, b in zip(corners, corners[1:])
    ]
    points = np.concatenate(points + [corners[-1:]])
    steps = np.diff(points, axis=0)
    yaws = np.arctan2(steps[:, 1], steps[:, 0])
    poses = [Pose.at(point, yaw) for point, yaw in zip(points, [*yaws, yaws[-1]])]
    return ControllerPlan(np.array([[*pose.position, *pose.orientation] for pose in poses]))


def followed(plan, start, **given):
    """Where a robot went: (N,3), and the result."""
    robot = SimulatedRobot(SurfaceRobot(PLANE, start))
    track, cancellation = [], Cancellation()

    def note(time):
        track.append(robot.body.pose.position.copy())
        if time > 120.0:
            cancellation.cancel("too long")

    execution = PathExecution(robot, SimulatedClock(robot, note))
    controller = controller_on(PLANE, **given)
    result = execution.run(controller, plan, Tolerances(0.1, 0.2), cancellation)
    return np.array([start.position, *track]), result


@pytest.mark.parametrize("spacing", [10.0, 0.5, 0.02])
@pytest.mark.parametrize("beside", [(0.0, 0.0), (-0.03, 0.05), (0.06, -0.02)])
def test_a_loop_is_driven_once_around(spacing, beside):
    plan = path_through([[2, 2, 0], [7, 2, 0], [7, 6, 0], [2, 6, 0], [2, 2, 0]], spacing)
    start = Pose.at([2.0 + beside[0], 2.0 + beside[1], 0.0], -np.pi / 2)
    track, result = followed(plan, start)
    assert result.outcome == 0, result.message
    driven = np.linalg.norm(np.diff(track, axis=0), axis=1).sum()
    assert driven == pytest.approx(18.0, abs=0.7)


def hits_of(mesh_map, start, goal, **given):
    """A drive, and how often the robot ran against the border."""
    robot = SimulatedRobot(SurfaceRobot(mesh_map, start, limits=STRONG))
    hits = []

    def watch(time, driven):
        hits.extend([time] if driven.body.obstruction else [])

    controller = controller_on(mesh_map, **given)
    went = drive(
        mesh_map, controller=controller, start=start, goal=goal, robot=robot, on_step=watch
    )
    return went, hits


def corridor():
    mesh = zoo.grid(cells=40)
    x, y = mesh.vertices[mesh.faces].mean(axis=1)[:, :2].T
    return MapWithCosts(mesh._replace(faces=mesh.faces[(y < 1) | (x > 9) | (y > 9)]))


@pytest.mark.parametrize("speed, brakes", [(1.0, 0.3), (2.0, 1.0), (5.0, 1.0), (5.0, 5.0)])
@pytest.mark.parametrize("follow", ["field", "path"])
def test_fast_robots_brake_before_bends(speed, brakes, follow):
    given = {"max_lin_velocity": speed, "max_lin_acceleration": brakes, "follow": follow}
    went, hits = hits_of(corridor(), Pose.at([0.5, 0.5, 0]), Pose.at([0.5, 9.5, 0], 3.1), **given)
    assert went.arrived, went.result.message
    assert not hits


@pytest.mark.parametrize("frequency", [20.0, 5.0])
@pytest.mark.parametrize("brakes", [1.0, 20.0])
@pytest.mark.parametrize("distance", [2.0, 10.0])
def test_what_appears_before_a_fast_robot_stops_it(frequency, brakes, distance):
    mesh = zoo.grid(cells=150, size=30.0)
    mesh_map, x = MapWithCosts(mesh), mesh.vertices[:, 0]
    wall = []

    def drop(time, robot):
        place = robot.body.pose.position[0]
        if place > 12.0 and not wall:
            wall.append(place + distance)
            mesh_map.costs = np.where((x > wall[0]) & (x < wall[0] + 1), np.inf, 0.0)

    start = Pose.at([1, 15.1, 0])
    robot = SimulatedRobot(SurfaceRobot(mesh_map, start, limits=STRONG))
    controller = controller_on(mesh_map, max_lin_velocity=5.0, max_lin_acceleration=brakes)
    went = drive(
        mesh_map,
        controller=controller,
        start=start,
        goal=Pose.at([29, 15.1, 0]),
        robot=robot,
        on_step=drop,
        values={"controller_frequency": frequency},
    )
    # The base needs 0.6 m to stop, and until it is told so it drives up to 1 m.
    assert "BLOCKED_PATH" in went.result.message
    assert len(went.blocked) == 0 and went.track[-1, 0] < wall[0]


def test_one_cycle_in_a_second_is_enough():
    went = drive(
        PLANE,
        controller=controller_on(PLANE),
        start=Pose.at([2, 2, 0]),
        goal=Pose.at([5, 5, 0], 2.0),
        values={"controller_frequency": 1.0},
        robot=SimulatedRobot(SurfaceRobot(PLANE, Pose.at([2, 2, 0])), command_timeout=2.0),
    )
    assert went.arrived, went.result.message
    assert went.times[-1] < 40.0


def test_a_creeping_robot_that_steers_to_both_sides_is_not_stuck():
    controller = following(PLANE, path_through([[2, 5, 0], [8, 5, 0]], 0.5))
    for cycle in range(400):
        pose = Pose.at([3.0 + 0.0005 * cycle, 5.0, 0.0], 0.04 * (-1) ** (cycle // 4))
        command = command_at(controller, pose, 0.05 * cycle)
        controller.set_parameters({"max_lin_velocity": 0.01})
        assert command.outcome == 0


def test_turning_that_moves_it_off_a_narrow_goal_is_made_good():
    controller = following(PLANE, path_through([[2, 5, 0], [8, 5, 0]], 0.5))

    def command(time, pose):
        assert not controller.is_goal_reached(RobotState(time, pose, STOP), 0.01, 0.01)
        return command_at(controller, pose, time).velocity

    assert command(0.0, Pose.at([8.0, 5.0, 0.0], 1.0)).x == 0.0
    speeds = [command(0.1 * i, Pose.at([7.97, 5.0, 0.0], 0.001)).x for i in range(1, 4)]
    assert max(speeds) > 0.0


@pytest.mark.parametrize("given", [{}, {"max_lin_velocity": 5.0, "max_ang_velocity": 2.0}])
@pytest.mark.parametrize("follow", ["field", "path"])
def test_straight_on_it_does_not_weave(follow, given):
    start, goal = Pose.at([1, 1, 0], 0.3), Pose.at([9, 8, 0], 0.7)
    went, _ = hits_of(PLANE, start, goal, follow=follow, **given)
    assert went.arrived, went.result.message
    aside = np.abs((went.track[:, :2] - 1.0) @ np.array([-7.0, 8.0]) / np.hypot(7.0, 8.0))
    assert aside[len(aside) // 4 :].max() < 0.1 and went.times[-1] < 15.0


def test_poses_that_repeat_change_nothing():
    plan = path_through([[2, 2, 0], [5, 2, 0], [5, 5, 0]], 0.25)
    repeated = ControllerPlan(np.repeat(plan.poses, 3, axis=0))
    tracks = [followed(each, Pose.at([2.0, 2.0, 0.0])) for each in (plan, repeated)]
    assert all(result.outcome == 0 for _, result in tracks)
    assert tracks[1][0][:, 1].max() < 5.05
    assert len(tracks[1][0]) == pytest.approx(len(tracks[0][0]), rel=0.05)
