"""Running one recovery behavior: patience, and an answer even if the behavior gives none."""

import threading
from typing import Any, Callable, Mapping

from mesh_map.base.parameter import Value
from mesh_msgs.text import one_line

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock, Stopwatch
from mesh_navigation.base.outcomes import RecoveryOutcome
from mesh_navigation.base.robot import GuardedRobot, MapGap, Robot, RobotLost
from mesh_navigation.execution.attempt import Attempt, fault_of_answer
from mesh_navigation.plugins.recovery import MeshRecovery, RecoveryResult

# Between two looks at the clock (s, of the computer's time): one that stands still holds up nobody.
LOOK = 0.05


class RecoveryExecution:
    """One run of a behavior in a thread of its own, under a watch.

    The robot stands when `run` returns, and what the behavior commands later does not reach it.
    """

    def __init__(
        self,
        robot: Robot,
        clock: Clock,
        values: Callable[[], Mapping[str, Value]],
    ) -> None:
        """
        Args:
            robot: to be driven.
            clock: by which patience is measured; any whose time goes on by itself.
            values: of the parameters, of which recovery_patience is read: longest time (s), 0: no
                limit.
        """
        self._robot = robot
        self._clock = clock
        self._values = values

    def run(
        self,
        behavior: MeshRecovery,
        cancellation: Cancellation,
        map_gone: Cancellation,
        map_fault: Callable[[], str] = lambda: "",
        map_gap: Callable[[], str] = lambda: "",
    ) -> RecoveryResult:
        """Run it to its end, or until it is canceled, or patience or the map is gone.

        Args:
            behavior: ready for a map.
            cancellation: ends it: CANCELED.
            map_gone: is canceled when its map is replaced: NOT_INITIALIZED.
            map_fault: why nobody may drive on that map, empty if one may. A behavior that moves the
                robot ends with it: NOT_INITIALIZED; others go on.
            map_gap: why nobody may drive on it just now. The robot stands, and a behavior that asks
                for its state waits as it does without a pose, in the end for NOT_INITIALIZED.
        """
        robot, clock = GuardedRobot(self._robot, map_fault, map_gap), self._clock
        attempt = Attempt("recovery", lambda stop: _result(behavior, robot, clock, stop))
        results, impatient, late = attempt.results, "", ""
        with cancellation.calling(attempt.wake.set), map_gone.calling(attempt.wake.set):
            if not attempt.wake.is_set():
                attempt.start()
                impatient = self._watch(attempt.wake, robot)
            else:
                results.append(_canceled("it did not start"))
        if not results:
            reason = impatient or cancellation.reason or map_gone.reason or robot.refusal
            attempt.cancellation.cancel(reason)
            robot.close()
            late = attempt.stop(reason, "behavior")
        robot.close()
        if cancellation.canceled and not (results and results[0].succeeded):
            return _canceled(f"{cancellation.reason}{late}")
        if map_gone.canceled:
            text = f"recovery stopped: {map_gone.reason}{late}"
            return RecoveryResult(RecoveryOutcome.NOT_INITIALIZED, text)
        if robot.refusal:
            text = f"recovery stopped: {robot.refusal}{late}"
            return RecoveryResult(RecoveryOutcome.NOT_INITIALIZED, text)
        if impatient:
            return RecoveryResult(RecoveryOutcome.PAT_EXCEEDED, impatient + late)
        return results[0]

    def _watch(self, wake: threading.Event, robot: GuardedRobot) -> str:
        """Wait for the end, or until the robot must not move; or why the patience is gone."""
        watch = Stopwatch(self._clock)
        while not (wake.wait(LOOK) or robot.look()):
            patience, seconds = self._values()["recovery_patience"], watch.seconds()
            if 0.0 < patience < seconds:
                return f"not done within the patience of {patience:.2f} s (recovery_patience)"
        return ""


def _canceled(reason: str) -> RecoveryResult:
    return RecoveryResult(RecoveryOutcome.CANCELED, f"recovery stopped: {reason}")


def _result(
    behavior: MeshRecovery, robot: Robot, clock: Clock, cancellation: Cancellation
) -> RecoveryResult:
    """What a behavior returns, with its own faults turned into outcomes."""
    try:
        return _checked(behavior.run(robot, clock, cancellation))
    except MapGap as error:
        return RecoveryResult(RecoveryOutcome.NOT_INITIALIZED, one_line(error))
    except RobotLost as error:
        return RecoveryResult(RecoveryOutcome.TF_ERROR, one_line(error))
    except (Exception, SystemExit) as error:  # A plugin may raise anything; its goal is answered.
        return _fault(f"it failed with {type(error).__name__}: {error}")


def _checked(returned: Any) -> RecoveryResult:
    fault = fault_of_answer(returned, RecoveryResult)
    if fault:
        return _fault(fault)
    outcome, message = returned
    return RecoveryResult(int(outcome), one_line(message) or f"outcome {int(outcome)}")


def _fault(what: str) -> RecoveryResult:
    text = one_line(f"the recovery behavior is at fault: {what}")
    return RecoveryResult(RecoveryOutcome.INTERNAL_ERROR, text)
