"""Running a planner for one goal: patience, retries, and answers even if the planner gives none."""

from typing import Any, Callable

import numpy as np

from mesh_msgs.text import one_line

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Deadline
from mesh_navigation.base.outcomes import GetPathOutcome, may_change_by_itself
from mesh_navigation.execution.attempt import Attempt, fault_of_answer
from mesh_navigation.execution.path_check import fault_of_poses
from mesh_navigation.plugins.planner import PlanResult

# Pause between two attempts (s): what may change by itself does not change at once.
RETRY_PAUSE = 0.1

Plan = Callable[[Cancellation], PlanResult]


class PlanExecution:
    """One goal's attempts to plan. ``run`` is called in the thread that waits for the answer."""

    def __init__(
        self,
        plan: Plan,
        patience: float,
        max_retries: int,
        may_clear: Callable[[], bool] = lambda: False,
    ) -> None:
        """
        Args:
            plan: makes one attempt; it stops when the `Cancellation` it gets says so.
            patience: longest time for all attempts together (s); 0: no limit.
            max_retries: attempts after the first; negative: as many as patience allows.
            may_clear: whether something that sensors see now may be what is in the way, and go.
        """
        self._plan = plan
        self._patience = patience
        self._max_retries = max_retries
        self._may_clear = may_clear

    def run(self, cancellation: Cancellation) -> PlanResult:
        """Plan until there is an answer, the patience is gone or ``cancellation`` is canceled."""
        deadline = Deadline(self._patience if self._patience > 0 else None)
        retries, failures = 0, ""
        while True:
            result = self._attempt(cancellation, deadline, failures)
            if retries == self._max_retries or not self._may_change(result):
                return result
            retries += 1
            failures = f"after {retries} attempts, the last of which: {result.message}"
            left = deadline.left
            cancellation.wait(RETRY_PAUSE if left is None else min(RETRY_PAUSE, left))
            if cancellation.canceled:
                return _canceled(cancellation)
            if deadline.left == 0.0:
                return self._impatient(failures)

    def _may_change(self, result: PlanResult) -> bool:
        """Whether the next attempt may end otherwise."""
        if result.outcome == GetPathOutcome.NO_PATH_FOUND:
            return not result.lasting and self._may_clear()
        return may_change_by_itself(result.outcome)

    def _attempt(self, cancellation: Cancellation, deadline: Deadline, failures: str) -> PlanResult:
        """One attempt, in a thread of its own: a planner that never returns blocks nobody.

        ``failures`` says what came before.
        """
        attempt = Attempt("plan", lambda stop: _answer(self._plan, stop))
        with cancellation.calling(attempt.wake.set):
            if cancellation.canceled:
                return _canceled(cancellation)
            attempt.start()
            attempt.wake.wait(deadline.left)
        if cancellation.canceled:
            result, reason = _canceled(cancellation), cancellation.reason
        elif attempt.results:
            return attempt.results[0]
        else:
            how = "and the planner was stopped"
            result = self._impatient(f"{how} {failures}" if failures else how)
            reason = "out of patience"
        result.message += attempt.stop(reason, "planner")
        return result

    def _impatient(self, how: str) -> PlanResult:
        return PlanResult(
            GetPathOutcome.PAT_EXCEEDED,
            f"no path within the patience of {self._patience:.2f} s (planner_patience) {how}",
        )


def _canceled(cancellation: Cancellation) -> PlanResult:
    return PlanResult(GetPathOutcome.CANCELED, f"planning stopped: {cancellation.reason}")


def _answer(plan: Plan, cancellation: Cancellation) -> PlanResult:
    """An attempt's result, with the planner's own faults turned into outcomes."""
    try:
        return checked_result(plan(cancellation))
    except (Exception, SystemExit) as error:  # A plugin may raise anything; its goal is answered.
        text = one_line(f"the planner failed with {type(error).__name__}: {error}")
        return PlanResult(GetPathOutcome.INTERNAL_ERROR, text)


def checked_result(returned: Any) -> PlanResult:
    """The result with an outcome and a message that can be sent, and with poses if it is a success.

    Whatever is no such result becomes INTERNAL_ERROR, or EMPTY_PATH for a success without poses; a
    failure keeps its outcome, and has neither poses nor a cost.
    """
    fault = fault_of_answer(returned, PlanResult)
    if fault:
        return _fault(fault)
    returned.outcome, returned.message = int(returned.outcome), one_line(returned.message)
    if not returned.succeeded:
        returned.poses, returned.cost = np.zeros((0, 7)), 0.0
        return returned
    fault = _fault_of_path(returned)
    if fault:
        return _fault(fault)
    if returned.poses.size == 0:
        message = f"the planner reported success without a pose: {returned.message}"
        return PlanResult(GetPathOutcome.EMPTY_PATH, message)
    return returned


def _fault(what: str) -> PlanResult:
    return PlanResult(GetPathOutcome.INTERNAL_ERROR, f"the planner is at fault: {what}")


def _fault_of_path(result: PlanResult) -> str:
    """What is wrong with the poses or the cost, empty if nothing is."""
    try:
        result.poses = np.asarray(result.poses, dtype=np.float64)
        result.cost = float(result.cost)
    except (TypeError, ValueError) as error:
        return f"its poses or cost are no numbers: {error}"
    poses = result.poses
    if poses.size == 0:
        return ""
    if poses.ndim != 2 or poses.shape[1] != 7:
        return f"its poses have shape {poses.shape}, not (N, 7)"
    if not np.isfinite(result.cost):
        return f"its cost is {result.cost}"
    return fault_of_poses(poses)
