"""What the mesh controller says when it cannot go on, and how it steers in single cycles."""

import numpy as np
import pytest

from mesh_msgs import zoo

from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import Pose, multiply
from mesh_navigation.base.robot import STOP, RobotState, Velocity
from mesh_navigation.controllers import mesh_controller
from mesh_navigation.controllers.carrot import find_carrot
from mesh_navigation.controllers.steering import (
    CLEARANCE,
    approached,
    braking_speed,
    stopping_distance,
)
from mesh_navigation.plugins.controller import ControlFailure, ControllerPlan
from controller_drives import command_at, controller_on, following, planned
from navigation_test_maps import MapWithCosts

GRID = zoo.grid(cells=50)
START, GOAL = Pose.at([2.0, 5.1, 0.0]), Pose.at([8.0, 5.1, 0.0], 1.0)


def plan_on(mesh_map=None):
    return planned(mesh_map or MapWithCosts(GRID), START, GOAL)


def failure(controller, pose, time=0.0):
    with pytest.raises(ControlFailure) as info:
        command_at(controller, pose, time)
    return info.value


def test_off_the_map():
    controller = following(MapWithCosts(GRID), plan_on())
    found = failure(controller, Pose.at([3.0, 5.1, 0.7]))
    assert found.outcome == ExePathOutcome.OUT_OF_MAP
    assert "0.70 m from the map, allowed are 0.40 m" in found.message
    state = RobotState(0.1, Pose.at([3.0, 5.1, 0.7]), STOP)
    assert not controller.is_goal_reached(state, 9.0, 9.0)


def test_base_frames_above_the_ground_are_on_the_map():
    low, high = (following(MapWithCosts(GRID), plan_on()) for _ in range(2))
    assert command_at(low, Pose.at([3.0, 5.1, 0.0])) == command_at(high, Pose.at([3.0, 5.1, 0.3]))


def test_far_from_the_path():
    controller = following(MapWithCosts(GRID), plan_on(), follow="path")
    found = failure(controller, Pose.at([4.0, 7.1, 0.0]))
    assert found.outcome == ExePathOutcome.MISSED_PATH
    assert "2.00 m from the path, allowed are 1.00 m" in found.message
    field = following(MapWithCosts(GRID), plan_on())
    assert command_at(field, Pose.at([4.0, 7.1, 0.0])).outcome == 0


def test_a_plan_without_a_field_is_followed_along_its_path_and_it_says_so_once():
    controller = following(MapWithCosts(GRID), plan_on()._replace(field=None))
    first = command_at(controller, START)
    assert first.message == "the plan has no field: its path is followed"
    assert command_at(controller, START, 0.05).message == ""
    # The field is final a little beyond the start.
    beyond = following(MapWithCosts(GRID), plan_on(), max_path_distance=3.0)
    assert "does not reach" in command_at(beyond, Pose.at([0.1, 5.1, 0.0])).message


def test_a_robot_that_does_not_move_is_stuck():
    controller = following(MapWithCosts(GRID), plan_on())
    times = np.arange(0.0, 3.9, 0.1)
    assert all(command_at(controller, START, time).outcome == 0 for time in times)
    outcomes = []
    for time in np.arange(3.9, 4.6, 0.1):
        try:
            outcomes.append(command_at(controller, START, time).outcome)
        except ControlFailure as stuck:
            outcomes.append(stuck.outcome)
            assert "does not move: in 4." in stuck.message
    assert outcomes[-1] == ExePathOutcome.ROBOT_STUCK
    controller.set_plan(plan_on())  # does not set it free
    assert failure(controller, START, 5.0).outcome == ExePathOutcome.ROBOT_STUCK
    assert command_at(controller, Pose.at([2.2, 5.1, 0.0]), 5.1).outcome == 0


def test_a_robot_that_turns_round_and_round_is_stuck():
    controller = following(MapWithCosts(GRID), plan_on())
    yaws = np.tile([1.0, 1.0, -1.0, -1.0], 60)
    times, outcomes = 0.2 * np.arange(len(yaws)), []
    for time, yaw in zip(times, yaws):
        try:
            outcomes.append(command_at(controller, Pose.at([2, 5.1, 0], yaw), time).outcome)
        except ControlFailure as stuck:
            assert stuck.outcome == ExePathOutcome.ROBOT_STUCK
            assert "turns without getting on" in stuck.message
            break
    assert len(outcomes) > 100


def test_no_speed_is_no_command():
    controller = following(MapWithCosts(GRID), plan_on(), max_lin_velocity=0.0)
    found = failure(controller, START)
    assert found.outcome == ExePathOutcome.NO_VALID_CMD and "max_lin_velocity" in found.message


def test_a_path_off_the_map_is_refused():
    poses = plan_on().poses.copy()
    poses[3, 2] = 5.0
    with pytest.raises(ControlFailure) as info:
        following(MapWithCosts(GRID), ControllerPlan(poses))
    assert info.value.outcome == ExePathOutcome.INVALID_PATH
    assert f"pose 3 of {len(poses)}" in str(info.value) and "5.00 m" in str(info.value)


@pytest.mark.parametrize("count", [1, 2])
def test_short_paths(count):
    controller = following(MapWithCosts(GRID), ControllerPlan(plan_on().poses[-count:]))
    command = command_at(controller, Pose.at([7.8, 5.1, 0.0]))
    assert command.outcome == 0 and command.velocity.x > 0.0


def test_without_a_plan():
    found = failure(controller_on(MapWithCosts(GRID)), START)
    assert found.outcome == ExePathOutcome.NOT_INITIALIZED


def test_the_goal_is_judged_by_this_cycle():
    controller = following(MapWithCosts(GRID), plan_on())
    near, away = Pose.at([7.95, 5.1, 0.2], 1.1), Pose.at([7.8, 5.1, 0.2], 1.1)
    turned = Pose.at([7.95, 5.1, 0.2], 1.3)
    answers = [
        controller.is_goal_reached(RobotState(0.0, pose, STOP), 0.1, 0.17)
        for pose in (away, near, away, turned)
    ]
    assert answers == [False, True, False, False]
    any_heading = following(MapWithCosts(GRID), plan_on(), turn_to_goal_heading=False)
    assert any_heading.is_goal_reached(RobotState(0.0, turned, STOP), 0.1, 0.17)


def test_it_turns_on_the_spot_to_what_is_beside_it():
    for yaw in (-2.0, -0.5, 0.5, 2.0):
        controller = following(MapWithCosts(GRID), plan_on())
        velocity = command_at(controller, Pose.at([3.0, 5.1, 0.0], yaw)).velocity
        assert velocity.x == 0.0 and velocity.yaw * yaw < 0.0
        assert controller.current_angle == pytest.approx(-yaw, abs=1e-6)


def test_parameters_hold_at_once():
    controller = following(MapWithCosts(GRID), plan_on())
    speeds = []
    for step in range(40):
        if step == 30:
            controller.set_parameters({"max_lin_velocity": 0.3})
        pose = Pose.at([2.0 + 0.05 * step, 5.1, 0.0])
        speeds.append(command_at(controller, pose, 0.05 * step).velocity.x)
    assert max(speeds[:30]) == 1.0 and max(speeds[30:]) <= 0.3


@pytest.mark.parametrize("period", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("deceleration", [0.1, 1.0, 20.0])
def test_braking_stops_within_the_distance(period, deceleration):
    for distance in (0.001, 0.1, 3.0):
        left, speed, first = distance, np.inf, True
        while left > 1e-4 * distance:
            wanted = braking_speed(left, deceleration, period)
            # From cycle to cycle no more than the deceleration is needed.
            assert first or wanted >= speed - deceleration * period - 1e-9
            speed, first = wanted, False
            left -= speed * period
            assert left >= -1e-12
            if speed < 1e-5:
                break
        assert left < 0.02
    assert braking_speed(0.0, deceleration, period) == braking_speed(-1.0, 1.0, period) == 0.0
    assert stopping_distance(2.0, 0.5, 0.1) == pytest.approx(0.2 + 4.0)
    assert approached(5.0, 1.0, 0.5) == 1.5 and approached(-5.0, 1.0, 0.5) == 0.5


@pytest.mark.parametrize("yaw", [-0.1, 0.3])
def test_a_tilted_robot_steers_by_its_heading_along_the_surface(yaw):
    upright = Pose.at([3.0, 5.1, 0.1], yaw)
    expected = command_at(following(MapWithCosts(GRID), plan_on()), upright).velocity
    for roll in (0.6, -0.6):
        rolled = multiply(upright.orientation, np.array([np.sin(roll / 2), 0, 0, np.cos(roll / 2)]))
        tilted = Pose(upright.position, rolled)
        found = command_at(following(MapWithCosts(GRID), plan_on()), tilted).velocity
        assert found == pytest.approx(expected)
    # Its left is on the other side where it hangs below.
    below = Pose(upright.position, multiply(upright.orientation, np.array([1.0, 0, 0, 0])))
    found = command_at(following(MapWithCosts(GRID), plan_on()), below).velocity
    assert found.yaw == pytest.approx(-expected.yaw) and found.x == pytest.approx(expected.x)
    nose_up = multiply(upright.orientation, np.array([0, -np.sin(np.pi / 4), 0, np.cos(np.pi / 4)]))
    stuck = failure(following(MapWithCosts(GRID), plan_on()), Pose(upright.position, nose_up))
    assert stuck.outcome == ExePathOutcome.NO_VALID_CMD and "no heading" in stuck.message


LOOKAHEAD = next(
    parameter.default
    for parameter in mesh_controller.PARAMETERS
    if parameter.name == "lookahead_distance"
)


def seeing_only(share, asked=None):
    """find_carrot() that sees no farther than this share of lookahead_distance."""

    def find(sight, paths, reach, clearance):
        if asked is not None:
            asked.append(reach)
        if reach > share * LOOKAHEAD + 1e-9:
            raise ControlFailure(ExePathOutcome.BLOCKED_PATH, "nothing is seen so far away")
        return find_carrot(sight, paths, reach, clearance)

    return find


@pytest.mark.parametrize("share", [0.5, 0.25])
def test_a_robot_that_sees_only_near_places_drives_no_faster_than_it_can_stop_there(
    share, monkeypatch
):
    controller = following(MapWithCosts(GRID), plan_on())
    monkeypatch.setattr(mesh_controller, "find_carrot", seeing_only(share))
    x, speed, fastest, period = 2.0, 0.0, 0.0, 0.05
    for cycle in range(60):
        pose = Pose.at([x, 5.1, 0.0])
        speed = command_at(controller, pose, cycle * period, Velocity(x=speed)).velocity.x
        x, fastest = x + speed * period, max(fastest, speed)
    assert x > 2.3, "it gets on"
    brakes = controller.values["max_lin_acceleration"]
    assert stopping_distance(fastest, brakes, period) + CLEARANCE <= share * LOOKAHEAD


def test_a_robot_that_saw_no_way_at_all_looks_as_far_as_ever_once_the_map_has_changed(monkeypatch):
    mesh_map = MapWithCosts(GRID)
    controller = following(mesh_map, plan_on(mesh_map))
    monkeypatch.setattr(mesh_controller, "find_carrot", seeing_only(0.0))
    for time in (0.0, 0.05):
        assert failure(controller, START, time).outcome == ExePathOutcome.BLOCKED_PATH
    asked = []
    monkeypatch.setattr(mesh_controller, "find_carrot", seeing_only(0.0, asked))
    failure(controller, START, 0.1)
    assert max(asked) < LOOKAHEAD, "as long as nothing has, it does not turn to and fro"
    mesh_map.costs = mesh_map.costs + np.float32(0.1)
    failure(controller, START, 0.15)
    monkeypatch.setattr(mesh_controller, "find_carrot", seeing_only(1.0, asked))
    asked.clear()
    assert command_at(controller, START, 0.2).velocity.x > 0.0
    assert asked == [LOOKAHEAD]
