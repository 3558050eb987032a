"""Driving along a path, cycle by cycle, with a simulated clock: each way in which it can end."""

import numpy as np
import pytest
from driving_fakes import FORWARD, TOLERANCES, PlaneRobot, SteppedClock, Told, plan_to, values_with

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.robot import STOP, RobotLost, Velocity
from mesh_navigation.execution.path_execution import PathExecution, Tolerances
from mesh_navigation.plugins.controller import Command, ControlFailure

SPIN = Velocity(0.0, 0.0, 0.5)
PLUGIN_FAILURES = sorted(
    (set(range(10, 150)) | {200, 255})
    - {101, 110, 112, 114, 116}  # CANCELED, and those that end at once
)


class World:
    """An execution with all that belongs to it."""

    def __init__(self, controller=None, at=(), map_fault=lambda: "", map_gap=lambda: "", **values):
        self.controller = controller or Told()
        self.robot, self.cycles = PlaneRobot(), []
        self.clock, self.cancellation = SteppedClock(self.robot, at), Cancellation()
        self.execution = PathExecution(
            self.robot,
            self.clock,
            values_with(**values),
            self.cycles.append,
            map_fault,
            map_gap,
        )

    def run(self, plan=None, tolerances=TOLERANCES):
        plan = plan or plan_to(2.0, 0.0)
        result = self.execution.run(self.controller, plan, tolerances, self.cancellation)
        assert result.message
        assert self.robot.command == STOP
        assert not self.execution.replace(plan, tolerances)
        return result

    def later(self, seconds, action):
        self.clock._at.append((seconds, action))
        self.clock._at.sort(key=lambda item: item[0])


def test_arrives():
    world = World()
    result = world.run()
    assert result.outcome == ExePathOutcome.SUCCESS and "0.075 m" in result.message
    assert 1.9 <= result.final_pose.position[0] <= 1.93
    assert result.dist_to_goal == pytest.approx(2.0 - result.final_pose.position[0])
    assert result.angle_to_goal == 0.0
    # 20 Hz: one command each, at the times it should be.
    times = [time for time, velocity in world.robot.commands if velocity == FORWARD]
    np.testing.assert_allclose(np.diff(times), 0.05, atol=1e-9)
    assert len(world.cycles) == len(times) + 1
    first = world.cycles[0]
    assert (first.outcome, first.velocity, first.dist_to_goal) == (0, FORWARD, 2.0)
    assert not any(cycle.late for cycle in world.cycles)
    assert len(world.robot.trail.back()) >= 25


@pytest.mark.parametrize("frequency, period", [(50.0, 0.02), (0.0, 0.05), (0.01, 1.0)])
def test_frequency(frequency, period):
    world = World(controller_frequency=frequency)
    world.run(tolerances=Tolerances(0.6, 1.0))
    times = [time for time, _ in world.robot.commands[:-1]]
    np.testing.assert_allclose(np.diff(times), period, atol=1e-9)


def test_goal_is_checked_with_the_pose_of_this_cycle():
    result = World().run(plan_to(0.05, 0.0))
    assert result.outcome == 0 and result.final_pose.position[0] == 0.0


def test_tolerance_check_of_the_server():
    controller = Told(Command(0, "", SPIN), reached=lambda state: False)
    world = World(controller, mbf_tolerance_check=True, cmd_vel_ignored_tolerance=0.0)
    result = world.run(plan_to(0.05, 0.0, yaw=1.0))
    assert result.outcome == 0 and 0.1 < result.angle_to_goal < 0.2
    assert all(cycle.angle_to_goal >= 0.2 for cycle in world.cycles[:-1])
    world = World(Told(reached=lambda state: False), at=[(9, lambda: world.cancellation.cancel())])
    assert world.run().outcome == ExePathOutcome.CANCELED
    assert world.robot.position[0] > 4.0


@pytest.mark.parametrize("outcome", PLUGIN_FAILURES)
def test_failures_are_retried_until_they_are_too_many(outcome):
    failure = Command(outcome, f"cannot, {outcome}", FORWARD)
    world = World(Told(Command(3, "", FORWARD), failure), controller_max_retries=4)
    result = world.run()
    assert result.outcome == outcome and f"cannot, {outcome}" in result.message
    assert "4" in result.message and "controller_max_retries" in result.message
    assert world.controller.asked == 1 + 5
    # The robot stands as soon as there is no valid command.
    assert [velocity for _, velocity in world.robot.commands[:3]] == [FORWARD, STOP, STOP]


def test_no_retries():
    world = World(Told(Command(108, "far")), controller_max_retries=0)
    assert world.run()[:2] == (108, "far") and world.controller.asked == 1


def test_retries_count_from_the_last_valid_command():
    bad, good = Command(100, "no"), Command(0, "", FORWARD)
    world = World(Told(bad, bad, good, bad, bad, good), controller_max_retries=2)
    assert world.run().outcome == 0


def test_patience_names_the_last_failure():
    failure = ControlFailure(109, "a wall at (1.00, 2.00)")
    world = World(Told(Command(0, "", FORWARD), failure), controller_patience=1.5)
    result = world.run()
    assert result.outcome == ExePathOutcome.PAT_EXCEEDED
    for word in ("controller_patience 1.50 s", "BLOCKED_PATH (109)", "a wall at (1.00, 2.00)"):
        assert word in result.message
    assert 1.5 < world.robot.time < 1.7


def test_patience_and_retries_without_limit():
    world = World(Told(ControlFailure(109, "a wall")), controller_patience=0.0)
    world.later(60.0, lambda: world.cancellation.cancel("enough"))
    result = world.run()
    assert result.outcome == ExePathOutcome.CANCELED and "enough" in result.message
    assert 1199 <= world.controller.asked <= 1201


@pytest.mark.parametrize("outcome", [110, 112, 114, 116])
def test_final_failures_end_at_once(outcome):
    world = World(Told(ControlFailure(outcome, "as it is")))
    assert world.run()[:2] == (outcome, "as it is") and world.controller.asked == 1


@pytest.mark.parametrize(
    "answer, outcome, words",
    [
        (ZeroDivisionError("by\nzero"), 114, "ZeroDivisionError: by zero"),
        (SystemExit(3), 114, "SystemExit"),
        (None, 114, "NoneType"),
        ((0, "", FORWARD), 114, "tuple"),
        (Command(-1, "x"), 114, "-1"),
        (Command(None, "x"), 114, "None"),
        (Command(0, "", None), 114, "TypeError"),
        (Command(0, "", (1.0, 2.0)), 114, "ValueError"),
        (Command(0, "", Velocity(np.nan)), 102, "nan"),
        (Command(0, "", Velocity(0.0, 0.0, -np.inf)), 102, "-inf"),
        (Command(105), 105, "OSCILLATION (105)"),
        (Command(147), 147, "147"),
        (ControlFailure(np.int64(108), "far"), 108, "far"),
        (RobotLost("where?"), 114, "RobotLost"),
    ],
)
def test_odd_answers(answer, outcome, words):
    world = World(Told(answer), controller_max_retries=0)
    result = world.run()
    assert result.outcome == outcome and type(result.outcome) is int and words in result.message
    assert {velocity for _, velocity in world.robot.commands} == {STOP}


def test_canceled_by_the_controller():
    assert World(Told(Command(101, "I stop"))).run()[:2] == (101, "I stop")


def test_plan_that_the_controller_refuses():
    failures = (ControlFailure(110, "one pose only"), 110), (ValueError("?"), 114)
    for failure, outcome in failures + ((ControlFailure(109, "a wall"), 109),):
        world = World(Told(on_plan=failure))
        assert world.run().outcome == outcome
        assert world.controller.asked == 0


def test_cancel_at_any_time():
    for when in np.random.default_rng(1).uniform(0.0, 3.0, size=50):
        world = World()
        world.later(when, lambda: world.cancellation.cancel("by a test"))
        result = world.run()
        assert result.outcome == ExePathOutcome.CANCELED and "by a test" in result.message
        assert world.robot.time == pytest.approx(when)


def test_cancel_while_the_controller_computes():
    world = World()

    def answer(state):
        world.cancellation.cancel("now")
        return Command(0, "", FORWARD)

    world.controller.answers = [answer]
    assert world.run().outcome == ExePathOutcome.CANCELED
    assert {velocity for _, velocity in world.robot.commands} == {STOP}


def test_cancel_before_the_start():
    world = World()
    world.cancellation.cancel("early")
    assert world.run().outcome == ExePathOutcome.CANCELED
    assert world.controller.plans == [] and world.robot.commands == [(0.0, STOP)]


def test_map_must_not_be_driven_on_any_longer():
    fault = [""]
    world = World(map_fault=lambda: fault[0])
    world.later(1.0, lambda: fault.insert(0, "layer steps: it hangs"))
    assert world.run()[:2] == (ExePathOutcome.MAP_ERROR, "layer steps: it hangs")
    assert 1.0 <= world.robot.time <= 1.051


def test_a_gap_in_what_sensors_see():
    """The robot stands, says why, and goes on; what that takes is nobody's fault."""
    gap = [""]
    world = World(
        map_gap=lambda: gap[-1],
        tf_timeout=1.0,
        controller_patience=3.0,
        cmd_vel_ignored_tolerance=1.0,
        oscillation_timeout=2.2,
        oscillation_distance=1.0,
    )
    for begin, end in ((1.0, 3.9), (5.0, 7.9)):
        world.later(begin, lambda: gap.append("layer obstacles: no cloud"))
        world.later(end, lambda: gap.append(""))
    world.later(3.85, lambda: lose(world))  # for a moment, as long as it is known in time
    world.later(4.5, lambda: lose(world, ""))
    assert world.run().outcome == 0
    during = [velocity for time, velocity in world.robot.commands if 1.05 < time < 3.9]
    assert len(during) > 50 and set(during) == {STOP}
    said = {cycle.message for cycle in world.cycles if cycle.outcome == ExePathOutcome.MAP_ERROR}
    assert said == {"layer obstacles: no cloud"}


def test_a_gap_that_takes_too_long():
    world = World(map_gap=lambda: "layer obstacles: no cloud", controller_patience=3.0)
    text = "layer obstacles: no cloud; waited for 3.0 s (controller_patience)"
    assert world.run()[:2] == (ExePathOutcome.MAP_ERROR, text)
    assert world.robot.time == pytest.approx(3.0, abs=0.051)
    world = World(map_gap=lambda: "layer obstacles: no cloud", controller_patience=0.0)
    world.later(500.0, lambda: world.cancellation.cancel("enough"))
    assert world.run().outcome == ExePathOutcome.CANCELED
    assert {velocity for _, velocity in world.robot.commands} == {STOP}


def test_a_lost_pose_says_more_than_the_gap_that_it_makes():
    gap = [""]
    world = World(map_gap=lambda: gap[-1], tf_timeout=2.0, controller_patience=1.5)
    world.later(1.0, lambda: (lose(world), gap.append("layer obstacles: no transform")))
    result = world.run()
    assert result.outcome == ExePathOutcome.TF_ERROR and "tf_timeout" in result.message
    said = {cycle.outcome for cycle in world.cycles}
    assert ExePathOutcome.MAP_ERROR not in said


def lose(world, why="no transform"):
    world.robot.lost = why


def test_pose_is_never_known():
    world = World(tf_timeout=2.0)
    lose(world)
    result = world.run()
    text = "no transform; waited for 2.0 s (tf_timeout)"
    assert result[:3] == (ExePathOutcome.TF_ERROR, text, None)
    assert np.isnan(result.dist_to_goal) and np.isnan(result.angle_to_goal)
    assert world.robot.time == pytest.approx(2.0, abs=0.051)
    assert {cycle.outcome for cycle in world.cycles} == {ExePathOutcome.TF_ERROR}


def test_pose_comes_late_or_is_lost_for_a_while():
    world = World(
        tf_timeout=2.0,
        controller_patience=0.5,
        oscillation_timeout=2.2,  # s, in which it gets on by as much, unless it has to wait
        oscillation_distance=1.0,
    )
    lose(world)
    world.later(1.5, lambda: lose(world, ""))
    world.later(2.5, lambda: lose(world))
    world.later(4.0, lambda: lose(world, ""))
    assert world.run().outcome == 0
    during = [velocity for time, velocity in world.robot.commands if 2.55 < time < 3.95]
    assert set(during) == {STOP} and world.robot.time > 5.4


def test_time_without_a_pose_is_not_the_controllers():
    answers = [Command(0, "", FORWARD)] * 10 + [Command(100, "not yet"), Command(0, "", FORWARD)]
    world = World(Told(*answers), controller_patience=1.0)
    world.later(0.49, lambda: lose(world))
    world.later(2.49, lambda: lose(world, ""))
    assert world.run().outcome == 0


def test_pose_is_lost_for_good():
    world = World(tf_timeout=2.0)
    world.later(1.0, lambda: lose(world))
    result = world.run()
    assert result.outcome == ExePathOutcome.TF_ERROR
    assert result.final_pose.position[0] == pytest.approx(0.5, abs=0.03)  # the last known one
    assert world.robot.time == pytest.approx(3.0, abs=0.1)
    assert world.robot.position[0] == pytest.approx(0.5, abs=0.03)


def test_time_jumps_back():
    world = World(controller_patience=1.0, oscillation_timeout=3.0)

    def jump():
        world.robot.time = -100.0

    world.later(1.0, jump)
    assert world.run().outcome == 0
    times = [time for time, _ in world.robot.commands]
    assert -100.0 in times and times[times.index(-100.0) + 1] == pytest.approx(-99.95)


def test_time_jumps_back_within_a_cycle():
    """The patience is measured from then on, as after any other jump."""

    def fail(state):
        if world.robot.time > 90.0:
            world.robot.time = 10.0
        return Command(ExePathOutcome.NO_VALID_CMD, "none")

    world = World(Told(fail), controller_patience=1.0)
    world.robot.time = 100.0
    world.later(30.0, lambda: world.cancellation.cancel("too late"))
    assert world.run().outcome == ExePathOutcome.PAT_EXCEEDED
    assert 11.0 <= world.robot.time <= 11.2


def test_time_jumps_back_during_failures():
    world = World(Told(Command(100, "no")), controller_patience=1.0)
    world.later(0.5, lambda: setattr(world.robot, "time", -100.0))
    assert world.run().outcome == ExePathOutcome.PAT_EXCEEDED
    assert world.robot.time == pytest.approx(-99.0, abs=0.06)


def test_late_cycles_skip_the_time_that_is_gone():
    world = World()

    def slow(state):
        world.robot.advance(0.12)
        return Command(0, "", FORWARD)

    world.controller.answers = [Command(0, "", FORWARD), slow, Command(0, "", FORWARD)]
    world.run()
    assert [cycle.late for cycle in world.cycles[:4]] == [False, True, False, False]
    times = [time for time, _ in world.robot.commands[:4]]
    np.testing.assert_allclose(times, [0.0, 0.17, 0.17, 0.22], atol=1e-9)


def test_oscillation():
    turn = [Command(0, "", SPIN)] * 6 + [Command(0, "", SPIN._replace(yaw=-0.5))] * 6
    world = World(Told(*turn * 100), oscillation_timeout=4.0, cmd_vel_ignored_tolerance=0.0)
    result = world.run()
    assert result.outcome == ExePathOutcome.OSCILLATION and "oscillation_distance" in result.message
    assert world.robot.time == pytest.approx(4.0, abs=0.11)


def test_turning_is_no_oscillation_and_failures_may_be():
    world = World(Told(Command(0, "", SPIN)), oscillation_timeout=10.0)
    world.later(60.0, lambda: world.cancellation.cancel())
    assert world.run().outcome == ExePathOutcome.CANCELED
    world = World(Told(Command(100, "no")), oscillation_timeout=2.0)
    assert world.run().outcome == ExePathOutcome.OSCILLATION


def test_a_new_plan_is_followed_without_a_stop():
    world = World()
    world.later(1.01, lambda: world.execution.replace(plan_to(3.0, 0.0), Tolerances(0.5, 1.0)))
    result = world.run()
    assert result.outcome == 0 and result.dist_to_goal == pytest.approx(0.5, abs=0.03)
    assert [velocity for _, velocity in world.robot.commands].count(STOP) == 1
    assert len(world.controller.plans) == 2


def test_a_new_plan_in_the_last_moment():
    """Whatever the end of the old plan would have been, the new one is followed."""
    for answer, first in ((Command(114, "broken"), 1), (Command(0, "", FORWARD), 1)):
        world = World(controller_max_retries=0)

        def reached(state):
            if len(world.controller.plans) == 1:
                assert world.execution.replace(plan_to(1.0, 0.0), TOLERANCES)
                world.controller.answers = [answer, Command(0, "", FORWARD)]
                return answer.outcome == 0
            return state.pose.position[0] > 0.9

        world.controller.reached = reached
        assert world.run().outcome == 0
        assert len(world.controller.plans) == 2


def test_a_new_plan_is_no_excuse():
    """Plans that come faster than the patience ends do not make it endless."""
    world = World(Told(ControlFailure(109, "a wall")), controller_patience=2.0)
    for second in np.arange(0.5, 60.0, 0.5):
        world.later(second, lambda: world.execution.replace(plan_to(3.0, 0.0), TOLERANCES))
    assert world.run().outcome == ExePathOutcome.PAT_EXCEEDED
    assert world.robot.time < 2.2


def test_a_new_plan_that_is_refused():
    world = World()

    def replace():
        world.controller.on_plan = ControlFailure(110, "bent")
        world.execution.replace(plan_to(3.0, 0.0), TOLERANCES)

    world.later(1.0, replace)
    assert world.run()[:2] == (110, "bent")


def test_a_plan_from_before_the_start():
    world = World()
    world.execution.replace(plan_to(1.0, 0.0), TOLERANCES)
    result = world.run(plan_to(5.0, 0.0))
    assert result.outcome == 0 and result.final_pose.position[0] < 1.0


def test_stops_when_a_listener_fails():
    world = World()
    world.execution = PathExecution(
        world.robot, world.clock, values_with(), lambda cycle: 1 / 0, lambda: True
    )
    with pytest.raises(ZeroDivisionError):
        world.run()
    assert world.robot.command == STOP


def test_a_new_plan_is_prepared_outside_of_the_cycle():
    class Prepares(Told):
        def prepare_plan(self, plan):
            return "ready for %g" % plan.poses[-1, 0]

    world = World(Prepares())
    assert world.execution.prepared(plan_to(1.0, 0.0)).prepared is None  # for nobody yet
    world.later(
        1.0,
        lambda: world.execution.replace(world.execution.prepared(plan_to(3.0, 0.0)), TOLERANCES),
    )
    assert world.run().outcome == 0
    assert [plan.prepared for plan in world.controller.plans] == [None, "ready for 3"]


@pytest.mark.parametrize("error", [ControlFailure(110, "bent"), ValueError("odd"), SystemExit()])
def test_a_plan_that_cannot_be_prepared_comes_as_it_is(error):
    class Fails(Told):
        def prepare_plan(self, plan):
            raise error

    world = World(Fails())
    newer = plan_to(3.0, 0.0)
    world.later(1.0, lambda: world.execution.replace(world.execution.prepared(newer), TOLERANCES))
    assert world.run().outcome == 0
    assert world.controller.plans[1] is newer
