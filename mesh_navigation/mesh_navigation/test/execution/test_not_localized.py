"""Drives of a robot of which its localizer does not know where it is, for a while or for good."""

import math

import numpy as np
import pytest
from driving_fakes import FORWARD, TOLERANCES, PlaneRobot, SteppedClock, Told, plan_to, values_with
from navigation_test_maps import MapWithCosts

from mesh_msgs import zoo
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, NotLocalized, RobotLost
from mesh_navigation.controllers.mesh_controller import MeshController
from mesh_navigation.execution.path_execution import PathExecution
from mesh_navigation.execution.planning import make_planner
from mesh_navigation.plugins.controller import ControlFailure, ControllerPlan
from mesh_navigation.simulation.driving import clearances
from mesh_navigation.simulation.simulated_robot import SimulatedClock, SimulatedRobot
from mesh_navigation.simulation.surface_robot import SurfaceRobot

WHY = "the robot is not localized: few rays are explained"


class World:
    """An execution, a robot on a plane, and what happens at certain times."""

    def __init__(self, *events, controller=None, **values):
        self.controller, self.robot, self.cycles = controller or Told(), PlaneRobot(), []
        clock = SteppedClock(self.robot, [(at, self.losing(lost)) for at, lost in events])
        self.cancellation = Cancellation()
        values = values_with(**values)
        self.execution = PathExecution(self.robot, clock, values, self.cycles.append)

    def losing(self, lost):
        return lambda: setattr(self.robot, "lost", lost)

    def run(self):
        return self.execution.run(self.controller, plan_to(2.0, 0.0), TOLERANCES, self.cancellation)

    def commands(self, begin, end):
        return {velocity for time, velocity in self.robot.commands if begin < time < end}


def test_it_stands_and_goes_on():
    """For longer than it would wait for a transform, or a controller for a command."""
    world = World((1.02, NotLocalized(WHY, 60.0)), (40.0, ""))
    result = world.run()
    assert result.outcome == ExePathOutcome.SUCCESS
    assert world.commands(1.02, 39.99) == {STOP}
    assert FORWARD in world.commands(0.9, 1.01) and FORWARD in world.commands(40.0, 40.1)
    lost = [cycle for cycle in world.cycles if cycle.state is None]
    assert {(cycle.outcome, cycle.message) for cycle in lost} == {(ExePathOutcome.TF_ERROR, WHY)}
    assert math.isnan(lost[0].dist_to_goal)


def test_patience_ends():
    world = World((1.0, NotLocalized(WHY, 20.0)), tf_timeout=1.0)
    result = world.run()
    assert result.outcome == ExePathOutcome.TF_ERROR
    assert result.message == f"{WHY}; waited for 20.0 s (localization_patience)"
    assert 20.9 < world.robot.time < 21.1
    assert result.final_pose.position[0] == pytest.approx(0.5, abs=0.05)  # the last that was known


def test_patience_without_end():
    world = World((1.0, NotLocalized(WHY, math.inf)), (9000.0, ""))
    assert world.run().outcome == ExePathOutcome.SUCCESS


def test_a_transform_is_waited_for_from_when_it_is_localized():
    lost = RobotLost("no transform")
    world = World((1.0, NotLocalized(WHY, 60.0)), (30.0, lost), (32.0, ""), tf_timeout=3.0)
    assert world.run().outcome == ExePathOutcome.SUCCESS
    world = World((1.0, NotLocalized(WHY, 60.0)), (30.0, lost), tf_timeout=3.0)
    result = world.run()
    assert (result.outcome, result.message) == (111, "no transform; waited for 3.0 s (tf_timeout)")
    assert 32.9 < world.robot.time < 33.1


def test_it_is_canceled():
    world = World((1.0, NotLocalized(WHY, 60.0)))
    world.execution._clock._at.append((5.0, lambda: world.cancellation.cancel("enough")))
    assert world.run().outcome == ExePathOutcome.CANCELED


def test_a_plan_begins_anew_where_the_robot_is_found():
    plans = []

    class Noting(Told):
        def set_plan(self, plan):
            super().set_plan(plan)
            plans.append((world.robot.time, plan.prepared))

    world = World((1.0, NotLocalized(WHY, 60.0)), (5.0, ""), controller=Noting())
    prepared = plan_to(2.0, 0.0)._replace(prepared="where it was")
    world.execution.run(world.controller, prepared, TOLERANCES, world.cancellation)
    assert world.controller.forgotten == [1]
    assert [prepared for _, prepared in plans] == ["where it was", None]
    assert plans[1][0] == pytest.approx(5.0, abs=0.06)


def test_the_trail_of_a_robot_that_was_elsewhere_is_forgotten():
    world = World((1.0, NotLocalized(WHY, 60.0)), (5.0, ""))
    before = []
    world.execution._clock._at.insert(1, (0.9, lambda: before.extend(world.robot.trail.back())))
    world.run()
    assert len(before) > 5
    assert min(pose.position[0] for pose in world.robot.trail.back()) >= 0.45


def test_a_plan_that_cannot_begin_anew_fails():
    class Refusing(Told):
        def forget_place(self):
            self.on_plan = ControlFailure(ExePathOutcome.INVALID_PATH, "not from here")

    world = World((1.0, NotLocalized(WHY, 60.0)), (5.0, ""), controller=Refusing())
    result = world.run()
    assert (result.outcome, result.message) == (110, "not from here")


def test_a_controller_that_fails_to_forget_is_at_fault():
    class Failing(Told):
        def forget_place(self):
            raise ZeroDivisionError("by zero")

    world = World((1.0, NotLocalized(WHY, 60.0)), (5.0, ""), controller=Failing())
    result = world.run()
    assert result.outcome == ExePathOutcome.INTERNAL_ERROR and "by zero" in result.message


# Carried away, with the controller of this package.

GRID = zoo.grid(cells=50, size=10.0)


class Kidnapped(SimulatedRobot):
    """After 2 s it is carried away, and for 4 s nobody knows where it is."""

    def __init__(self, mesh_map, there):
        super().__init__(SurfaceRobot(mesh_map.geometry, Pose.at((1.0, 5.0, 0.0))))
        self.there, self.commands, self.track = there, [], []

    def state(self):
        if 2.0 < self.time < 6.0:
            raise NotLocalized(WHY, 60.0)
        return super().state()

    def drive(self, velocity):
        super().drive(velocity)
        self.commands.append((self.time, velocity))

    def advance(self, seconds):
        super().advance(seconds)
        self.track.append((self.time, self.body.pose.position.copy()))
        if self.there is not None and self.time > 3.0:
            there, self.there = self.there, None
            self.put(there)


def carried(costs, there, follow="field", with_field=True):
    mesh_map = MapWithCosts(GRID, costs)
    controller = MeshController()
    assert controller.initialize("controller", mesh_map, {"follow": follow}) == []
    robot = Kidnapped(mesh_map, there)
    made = make_planner(mesh_map, "wave_front").make_plan(robot.state().pose, Pose.at((9, 5, 0)))
    assert made.succeeded
    plan = ControllerPlan(made.poses, made.plan_field if with_field else None)
    execution = PathExecution(robot, SimulatedClock(robot), values_with())
    result = execution.run(controller, plan, TOLERANCES, Cancellation())
    assert {velocity for time, velocity in robot.commands if 2.05 < time < 6.0} == {STOP}
    after = np.array([place for time, place in robot.track if time > 6.0])
    return result, after, clearances(mesh_map, after)


def wall():
    """Along the path, 0.6 m beside it, up to x = 7 m."""
    x, y = GRID.vertices[:, 0], GRID.vertices[:, 1]
    return np.where((np.abs(y - 5.6) < 0.11) & (x < 7.0), np.inf, 0.0)


def test_a_robot_that_is_far_from_its_path_does_not_drive_back():
    for follow, with_field in (("path", True), ("field", False)):
        result, after, _ = carried(None, Pose.at((5.0, 8.0, 0.0)), follow, with_field)
        assert result.outcome == ExePathOutcome.PAT_EXCEEDED, result.message
        assert "MISSED_PATH" in result.message and "max_path_distance" in result.message
        assert np.ptp(after, axis=0).max() < 1e-6


def test_a_robot_behind_a_wall_beside_its_path_does_not_drive_through():
    result, after, clearance = carried(wall(), Pose.at((5.0, 6.0, 0.0)), "path")
    assert result.outcome != ExePathOutcome.SUCCESS
    assert after[:, 1].min() > 5.6 and clearance.min() > 0.05


def test_a_robot_that_follows_the_field_goes_round_the_wall_from_where_it_is():
    result, after, clearance = carried(wall(), Pose.at((5.0, 6.4, 0.0)))
    assert result.outcome == ExePathOutcome.SUCCESS, result.message
    assert clearance.min() > 0.05
    assert np.interp(5.6, after[::-1, 1], after[::-1, 0]) > 7.0  # where the wall ends


def test_a_robot_that_was_put_a_little_aside_goes_on():
    result, _, _ = carried(None, Pose.at((3.0, 5.5, 0.0)), "path")
    assert result.outcome == ExePathOutcome.SUCCESS, result.message
