"""One run of a recovery behavior: outcomes, patience, cancels; and the robot stands at the end."""

import random
import threading
import time

import pytest
from driving_fakes import SystemClock

from mesh_msgs.testing import wait_until
from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.pose import Pose
from mesh_navigation.base.robot import STOP, Robot, RobotLost, RobotState, Trail, Velocity
from mesh_navigation.execution.recovery_execution import RecoveryExecution
from mesh_navigation.plugins.recovery import MeshRecovery, RecoveryResult

BACK = Velocity(-0.2)


class FakeRobot(Robot):
    def __init__(self):
        self.trail, self.commands = Trail(), []

    def state(self):
        return RobotState(0.0, Pose.at((0, 0, 0)), STOP)

    def drive(self, velocity):
        self.commands.append(velocity)


class Scripted(MeshRecovery):
    """Does what a function says."""

    def __init__(self, run):
        self.run = run


class Run:
    """One run in this thread; `after` may act meanwhile."""

    def __init__(self, run, clock=None, patience=0.0, after=None):
        self.robot = FakeRobot()
        self.cancellation, self.map_gone = Cancellation(), Cancellation()
        values = {"recovery_patience": patience}
        clock = clock or SystemClock()
        execution = RecoveryExecution(self.robot, clock, lambda: values)
        if after:
            threading.Thread(target=after, args=(self,), daemon=True).start()
        self.fault = self.gap = ""
        self.result = execution.run(
            Scripted(run),
            self.cancellation,
            self.map_gone,
            lambda: self.fault,
            lambda: self.gap,
        )

    def stands(self):
        return self.robot.commands[-1] == STOP


def until_canceled(robot, clock, cancellation):
    while not cancellation.canceled:
        robot.drive(BACK)
        clock.wait_until(clock.now() + 0.01, cancellation)
    return RecoveryResult(151, f"stopped: {cancellation.reason}")


def returning(value):
    return lambda robot, clock, cancellation: value


@pytest.mark.parametrize("outcome", [0, 1, 9, 150, 151, 158, 171, 199])
def test_outcomes_are_passed_on(outcome):
    run = Run(returning(RecoveryResult(outcome, "so it is")))
    assert run.result == (outcome, "so it is") and run.robot.commands == [STOP]


@pytest.mark.parametrize(
    "returned, words",
    [
        (None, "it returned a NoneType"),
        ((0, "fine"), "it returned a tuple"),
        (RecoveryResult(-1, "?"), "its outcome is -1"),
        (RecoveryResult(256, "?"), "its outcome is 256"),
        (RecoveryResult(1.0, "?"), "its outcome is 1.0"),
    ],
)
def test_what_is_no_result_is_a_fault(returned, words):
    result = Run(returning(returned)).result
    assert result.outcome == 156 and words in result.message


def test_an_empty_message_gets_words():
    assert Run(returning(RecoveryResult(7, ""))).result == (7, "outcome 7")


@pytest.mark.parametrize(
    "error, outcome, words",
    [
        (RobotLost("the pose is 3.1 s old"), 153, "the pose is 3.1 s old"),
        (ZeroDivisionError("by zero"), 156, "failed with ZeroDivisionError: by zero"),
        (SystemExit(3), 156, "failed with SystemExit: 3"),
    ],
)
def test_errors_become_outcomes(error, outcome, words):
    def fail(robot, clock, cancellation):
        robot.drive(BACK)
        raise error

    run = Run(fail)
    assert run.result.outcome == outcome and words in run.result.message
    assert run.robot.commands == [BACK, STOP]


def test_patience():
    run = Run(until_canceled, patience=0.15)
    assert run.result == (152, "not done within the patience of 0.15 s (recovery_patience)")
    assert run.stands()


class StandingClock(Clock):
    """The time of a simulation that stands still until it is told to go on."""

    def __init__(self):
        self.time = 100.0

    def now(self):
        return self.time

    def wait_until(self, moment, cancellation):
        while self.time < moment and not cancellation.wait(0.005):
            pass


def test_patience_is_by_the_clock():
    clock = StandingClock()

    def act(run):
        time.sleep(0.3)
        clock.time = 103.0
        time.sleep(0.2)
        clock.time = 50.0  # the simulation begins anew
        time.sleep(0.2)
        clock.time = 53.0

    run = Run(until_canceled, clock, patience=5.0, after=act)
    assert run.result.outcome == 152 and clock.time == 53.0


def test_a_behavior_that_does_not_listen():
    released = threading.Event()
    drove = threading.Event()

    def deaf(robot, clock, cancellation):
        robot.drive(BACK)
        released.wait(30)
        robot.drive(BACK)
        drove.set()
        return RecoveryResult(0, "too late")

    run = Run(deaf, patience=0.1)
    assert run.result.outcome == 152
    assert "the behavior did not stop within 0.5 s" in run.result.message
    released.set()
    assert drove.wait(30) and run.robot.commands == [BACK, STOP]


def test_a_cancel():
    def act(run):
        while not run.robot.commands:
            time.sleep(0.001)
        run.cancellation.cancel("a client canceled the goal")

    run = Run(until_canceled, after=act)
    assert run.result == (151, "recovery stopped: a client canceled the goal") and run.stands()


def test_a_behavior_does_not_move_the_robot_without_a_layer():
    """It is stopped at once, also where it commands nothing more; one that stands goes on."""

    def once(robot, clock, cancellation):
        robot.drive(BACK)
        cancellation.wait(60)
        robot.drive(BACK)
        return RecoveryResult(0, "done")

    def act(run):
        while not run.robot.commands:
            time.sleep(0.001)
        run.fault = "layer steps: it hangs"

    for behavior in (once, until_canceled):
        run = Run(behavior, after=act)
        assert run.result == (154, "recovery stopped: layer steps: it hangs") and run.stands()
        assert BACK not in run.robot.commands[run.robot.commands.index(STOP) :]

    def standing(robot, clock, cancellation):
        robot.drive(STOP)
        run_of.append(cancellation.wait(0.2))
        return RecoveryResult(0, "waited")

    run_of = []
    robot = FakeRobot()
    execution = RecoveryExecution(robot, SystemClock(), lambda: {"recovery_patience": 0.0})
    arguments = Scripted(standing), Cancellation(), Cancellation(), lambda: "layer steps: it hangs"
    assert execution.run(*arguments) == (0, "waited")


@pytest.mark.parametrize("patience, outcome", [(60.0, 0), (0.0, 154)])
def test_a_behavior_waits_where_the_map_has_a_gap(patience, outcome):
    """The robot stands meanwhile, and goes on when that is over, or it takes too long."""

    def twice(robot, clock, cancellation):
        robot.drive(BACK)
        assert is_known.wait(60)
        robot.lost_timeout = patience
        robot.awaited_state(clock, cancellation)
        robot.drive(BACK)
        return RecoveryResult(0, "done")

    def act(run):
        wait_until(lambda: run.robot.commands, "motion")
        run.gap = "no cloud"
        is_known.set()
        wait_until(lambda: run.robot.commands[-1] == STOP, "a stop")
        assert STOP in run.robot.commands
        if patience:
            time.sleep(0.3)
            run.gap = ""

    is_known = threading.Event()
    run = Run(twice, after=act)
    assert run.result == (outcome, "no cloud" if outcome else "done") and run.stands()
    assert run.robot.commands.count(BACK) == (1 if outcome else 2)


def test_a_cancel_before_the_start():
    ran = []
    robot, canceled = FakeRobot(), Cancellation()
    canceled.cancel("at once")
    execution = RecoveryExecution(robot, SystemClock(), lambda: {"recovery_patience": 1.0})
    result = execution.run(Scripted(lambda *args: ran.append(args)), canceled, Cancellation())
    assert result == (151, "recovery stopped: at once") and not ran and robot.commands == [STOP]


@pytest.mark.parametrize("before", [True, False])
def test_a_map_that_is_replaced(before):
    robot, gone = FakeRobot(), Cancellation()
    execution = RecoveryExecution(robot, SystemClock(), lambda: {"recovery_patience": 0.0})
    if before:
        gone.cancel("the map is loaded anew")
    else:
        threading.Timer(0.1, gone.cancel, ["the map is loaded anew"]).start()
    result = execution.run(Scripted(until_canceled), Cancellation(), gone)
    assert result == (154, "recovery stopped: the map is loaded anew")
    assert robot.commands[-1] == STOP


def test_two_hundred_cancels_at_random_times():
    pauses = random.Random(0)
    for _ in range(200):

        def short(robot, clock, cancellation):
            robot.drive(BACK)
            clock.wait_until(clock.now() + pauses.uniform(0, 0.004), cancellation)
            return RecoveryResult(0, "done")

        def act(run):
            time.sleep(pauses.uniform(0, 0.005))
            run.cancellation.cancel("now")

        run = Run(short, after=act)
        assert run.result in ((0, "done"), (151, "recovery stopped: now")) and run.stands()
