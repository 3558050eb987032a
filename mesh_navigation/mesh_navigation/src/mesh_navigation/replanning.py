"""Newer plans while the robot drives."""

from typing import Callable, Optional

from mesh_navigation.cancellation import Cancellation
from mesh_navigation.move_base_end import stopped
from mesh_navigation.sub_goals import SubActions, SubEnd, SubGoal

# Nearer to the goal than this there are no new plans (m): they would only disturb the arrival.
NEAR = 0.1


class Replanning:
    """Asks for plans at a frequency, one at a time."""

    def __init__(self, actions: SubActions, now: float, log: Callable[[str], None]) -> None:
        """
        Args:
            actions: makes the plans.
            now: time (s); the robot has just got a plan.
            log: gets sentences about plans that fail.
        """
        self._actions = actions
        self._log = log
        self._last = now
        self._plan: Optional[SubGoal] = None
        self._failure: Optional[int] = None

    def newer_plan(self, now: float, frequency: float, dist_to_goal: float) -> Optional[SubEnd]:
        """A plan that succeeded, as soon as there is one; never waits.

        Args:
            now: time (s); it may jump back.
            frequency: of new plans (Hz); 0: none.
            dist_to_goal: m.
        """
        if self._plan is not None:
            end = self._plan.wait(Cancellation(), 0.0)
            if end is None:
                return None
            self._plan = None
            self._note(end)
            return end if end.succeeded and dist_to_goal > NEAR else None
        since = now - self._last
        if frequency > 0.0 and dist_to_goal > NEAR and not 0.0 <= since < 1.0 / frequency:
            self._last = now
            self._plan = self._actions.plan()
        return None

    def end(self, reason: str) -> None:
        """No more plans; returns when none is made any more."""
        plan, self._plan = self._plan, None
        if plan is not None:
            stopped(plan, reason)

    def _note(self, end: SubEnd) -> None:
        failure = None if end.succeeded else end.outcome
        # Plans come every second, and fail for the same reason then: once is enough.
        if failure != self._failure:
            if failure is None:
                self._log("planning succeeds again")
            else:
                self._log(
                    f"no new plan, the robot follows the old one: {end.message} ({end.outcome})"
                )
        self._failure = failure
