"""Robots that do not obey, and robots that only seem so."""

import numpy as np
import pytest
from driving_fakes import PlaneRobot

from mesh_navigation.base.pose import Pose
from mesh_navigation.base.progress_watch import ProgressWatch
from mesh_navigation.base.robot import STOP, RobotState, Velocity
from mesh_navigation.execution.drive_watches import ObedienceWatch, OscillationWatch

SLOW, FORWARD = Velocity(0.0015), Velocity(0.4)


def fault_after(robot, command, seconds=30.0, tolerance=5.0, noise=0.0, period=0.05, measured=None):
    """When the watch complains (s), None if it does not; and what it says."""
    watch, random = ObedienceWatch(), np.random.default_rng(3)
    while robot.time < seconds:
        state = robot.state()
        state.pose.position[:2] += noise * random.standard_normal(2)
        if measured is not None:
            state = RobotState(state.time, state.pose, measured)
        velocity = command(robot.time) if callable(command) else command
        fault = watch.fault(state, velocity, robot.time, tolerance)
        if fault:
            return robot.time, fault
        robot.command = velocity
        robot.advance(period)
    return None, ""


def stuck():
    robot = PlaneRobot()
    robot.obeys = False
    return robot


@pytest.mark.parametrize("command", [FORWARD, Velocity(-0.1), Velocity(yaw=0.2), Velocity(y=0.1)])
def test_a_robot_that_stands(command):
    when, fault = fault_after(stuck(), command)
    assert 5.0 < when < 5.2
    assert "cmd_vel_ignored_tolerance 5.0 s" in fault and "told to move by" in fault


@pytest.mark.parametrize("tolerance", [0.0, -1.0])
def test_not_watched(tolerance):
    assert fault_after(stuck(), FORWARD, tolerance=tolerance)[0] is None


@pytest.mark.parametrize("command", [FORWARD, SLOW, Velocity(yaw=0.1), Velocity(0.002, 0, 0.002)])
def test_a_robot_that_moves(command):
    """Also where odometry always says that it stands; and very slowly."""
    assert fault_after(PlaneRobot(), command)[0] is None
    if command not in (SLOW, (0.002, 0, 0.002)):
        assert fault_after(PlaneRobot(), command, measured=STOP)[0] is None


def test_noise_of_localization_is_no_motion_where_odometry_says_so():
    assert fault_after(stuck(), FORWARD, noise=0.01, measured=STOP)[0] < 5.2
    assert fault_after(stuck(), FORWARD, noise=0.01)[0] is None


def test_commands_to_stand_are_obeyed():
    assert fault_after(stuck(), lambda time: FORWARD if time % 4 < 3 else STOP)[0] is None
    assert fault_after(stuck(), Velocity(0.0005, 0.0, 0.0005))[0] is None


def test_long_cycles_are_no_disobedience():
    assert fault_after(stuck(), FORWARD, period=6.0)[0] is None
    assert fault_after(stuck(), FORWARD, period=1.0)[0] == 6.0


def test_time_jumps_back():
    robot, watch = stuck(), ObedienceWatch()
    for now in (0.0, 1.0, 2.0, -9.0, -8.0, -7.0, -6.0, -5.0, -4.0):
        assert watch.fault(robot.state(), FORWARD, now, 5.0) == ""
    assert watch.fault(robot.state(), FORWARD, -3.0, 5.0)


@pytest.mark.parametrize("step", [0.01, -0.025, 0.5])
def test_turning_is_getting_on(step):
    """Also by an angle that the shortest turn between two poses never has."""
    watch, times = ProgressWatch(), []
    for cycle in range(int(20 / abs(step))):
        if watch.got_on(Pose.at((0, 0, 0), cycle * step), float(cycle), 0.5, 4.0):
            times.append(cycle * abs(step))
    assert len(times) == 4
    assert 4.0 <= np.diff([0.0, *times]).min() and np.diff([0.0, *times]).max() <= 4.0 + 2 * abs(
        step
    )


def test_turning_to_and_fro_is_not():
    watch = ProgressWatch()
    assert not any(
        watch.got_on(Pose.at((0, 0, 0), np.sin(cycle / 10)), float(cycle), 0.5, 3.14)
        for cycle in range(1000)
    )
    assert watch.seconds(1000.0) == 1000.0


def test_oscillation_is_told_of_after_its_timeout():
    """Neither sooner nor later, from the last time on that the robot got on; 0: never."""
    values = {"oscillation_timeout": 4.0, "oscillation_distance": 0.5, "oscillation_angle": 3.14}
    watch, stands = OscillationWatch(), Pose.at((0, 0, 0))
    assert [bool(watch.fault(stands, now, values)) for now in (10.0, 13.9, 14.1)] == [0, 0, 1]
    moved = Pose.at((0.6, 0, 0))
    assert [bool(watch.fault(moved, now, values)) for now in (14.2, 18.1, 18.3)] == [0, 0, 1]
    assert "for 4.1 s (oscillation_timeout 4.0 s)" in watch.fault(moved, 18.3, values)
    watch.restart()
    assert not watch.fault(moved, 18.4, values)
    assert not watch.fault(moved, 99.0, dict(values, oscillation_timeout=0.0))
