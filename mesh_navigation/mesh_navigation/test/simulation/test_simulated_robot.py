"""The robot that obeys the newest command, and the clock that drives it."""

import math

import numpy as np
import pytest

from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.pose import Pose, transformed
from mesh_navigation.base.robot import STOP, Velocity
from mesh_navigation.simulation.ros.step_time_ros import Pacing
from mesh_navigation.simulation.robot_messages import inverted, odometry_origin
from mesh_navigation.simulation.simulated_robot import SimulatedClock, SimulatedRobot
from mesh_navigation.simulation.surface_robot import SurfaceRobot
from mesh_navigation.simulation.wheels import BaseLimits

PLANE = MeshMap(zoo.grid().vertices, zoo.grid().faces)
AT_ONCE = BaseLimits(math.inf, math.inf, math.inf, math.inf, math.inf)


def robot_at(x=2.0, **others):
    return SimulatedRobot(SurfaceRobot(PLANE, Pose.at((x, 5, 0)), limits=AT_ONCE), **others)


def test_waiting_lets_the_robot_drive():
    robot = robot_at()
    moments = []
    clock = SimulatedClock(robot, lambda time: moments.append((time, robot.state().time)))
    robot.drive(Velocity(1.0))
    clock.wait_until(0.45, Cancellation())
    assert clock.now() == pytest.approx(0.45, abs=1e-9)
    assert robot.state().pose.position == pytest.approx([2.45, 5, 0], abs=1e-9)
    assert robot.state().velocity == Velocity(1.0)
    assert all(time == seen for time, seen in moments)
    assert np.diff([time for time, _ in moments]).max() <= 0.02 * 1.002
    clock.wait_until(0.45, Cancellation())  # past moments take no time
    clock.wait_until(0.1, Cancellation())
    assert clock.now() == pytest.approx(0.45, abs=1e-9)


@pytest.mark.parametrize("step", [0.02, 0.3, 5.0])
def test_a_command_holds_until_its_time_is_over(step):
    robot = robot_at(command_timeout=0.5)
    robot.drive(Velocity(1.0))
    SimulatedClock(robot, step=step).wait_until(3.0, Cancellation())
    assert robot.state().pose.position[0] == pytest.approx(2.5, abs=1e-9)
    assert robot.state().velocity == STOP
    robot.drive(Velocity(1.0))
    robot.advance(0.2)
    robot.drive(Velocity(1.0))  # from now on
    robot.advance(1.0)
    assert robot.state().pose.position[0] == pytest.approx(3.2, abs=1e-9)


def test_what_is_not_finite_stops_it():
    robot = robot_at()
    robot.drive(Velocity(1.0, math.nan))
    robot.advance(1.0)
    assert robot.state().pose.position[0] == 2
    assert robot.last_command == STOP


def test_a_cancel_stops_time():
    robot = robot_at()
    cancellation = Cancellation()
    clock = SimulatedClock(robot, lambda time: time > 0.999 and cancellation.cancel())
    clock.wait_until(50.0, cancellation)
    assert clock.now() == pytest.approx(1.0)
    clock.wait_until(50.0, cancellation)
    assert clock.now() == pytest.approx(1.0)


def test_noise_of_the_pose_is_told_only():
    robot = robot_at(pose_noise=0.1, heading_noise=0.2, seed=5)
    states = [robot.state() for _ in range(300)]
    positions = np.array([state.pose.position for state in states])
    headings = np.array([state.pose.heading for state in states])
    assert positions.std(axis=0) == pytest.approx([0.1, 0.1, 0.1], rel=0.2)
    assert np.arctan2(headings[:, 1], headings[:, 0]).std() == pytest.approx(0.2, rel=0.2)
    assert all(state.pose.fault() is None for state in states)
    assert robot.body.pose.position.tolist() == [2, 5, 0]
    again = robot_at(pose_noise=0.1, heading_noise=0.2, seed=5)
    assert again.state().pose.position.tolist() == positions[0].tolist()


def test_it_can_be_put_elsewhere():
    robot = robot_at()
    robot.put(Pose.at((7, 7, 0), 1.0))
    assert robot.state().pose.position == pytest.approx([7, 7, 0])


def test_the_odometry_seen_from_its_origin_is_the_truth():
    random = np.random.default_rng(2)
    for _ in range(50):
        truth, odometry = (
            Pose(random.normal(size=3), random.normal(size=4)).normalized() for _ in range(2)
        )
        seen = transformed(odometry, odometry_origin(truth, odometry))
        assert seen.position == pytest.approx(truth.position, abs=1e-12)
        assert abs(seen.orientation @ truth.orientation) == pytest.approx(1, abs=1e-12)
        same = transformed(inverted(truth), truth)
        assert same.position == pytest.approx(np.zeros(3), abs=1e-12)
        assert abs(same.orientation[3]) == pytest.approx(1, abs=1e-12)


def test_pacing_keeps_the_ratio_and_does_not_rush():
    pacing = Pacing(2.0, wall=100.0)
    assert pacing.pause(1.0, 100.0) == pytest.approx(0.5)
    assert pacing.pause(1.0, 100.5) == pytest.approx(0.5)
    assert pacing.pause(1.0, 101.1) == pytest.approx(0.4)  # 0.1 s late, caught up
    assert pacing.pause(1.0, 200.0) == 0.0
    assert pacing.pause(1.0, 200.0) == pytest.approx(0.4)  # 0.1 s may be caught up, not 98
    assert Pacing(0.0, wall=0.0).pause(1.0, 0.0) == 0.0
    with pytest.raises(ValueError, match="real time factor is -1"):
        Pacing(-1.0, wall=0.0)
