"""A drive along a plan and those that replace it meanwhile, and how these are asked for."""

from typing import Any, Callable, List, Optional

import numpy as np

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.move_base.sub_goals import GoalEnd, DriveProgress, SubActions, SubGoal


class Relay(SubGoal):
    """A drive along a path, and along newer ones, each of which is a goal of its own.

    What ends is the newest. But somebody who cancels the drive just when the next one is sent means
    the robot: then the newest is canceled as well.
    """

    def __init__(self, actions: SubActions, path: Any) -> None:
        """
        Args:
            actions: sends the goals.
            path: the first one.
        """
        self._actions = actions
        self.progress: Optional[DriveProgress] = None
        """The newest that was reported; None where the robot's pose is not known."""
        self._first: Optional[DriveProgress] = None
        self._older: List[SubGoal] = []
        self._newest = actions.drive(path, self._note)

    def _note(self, progress: Optional[DriveProgress]) -> None:
        self._first = self._first or progress
        self.progress = progress

    def distance(self) -> float:
        """How far away the robot is from where it was reported first (m)."""
        first, newest = self._first, self.progress
        if first is None or newest is None:
            return 0.0
        return float(np.linalg.norm(newest.pose.position - first.pose.position))

    def follow(self, path: Any) -> None:
        """Go on along a newer path."""
        self._older.append(self._newest)
        self._newest = self._actions.drive(path, self._note)

    def cancel(self, reason: str) -> None:
        self._newest.cancel(reason)

    def wait(
        self, cancellation: Optional[Cancellation] = None, timeout: Optional[float] = None
    ) -> Optional[GoalEnd]:
        end = self._newest.wait(cancellation, timeout)
        if end is not None and end.succeeded:
            return end
        canceled = self._canceled_before()
        if canceled is None:
            return end
        end = self._newest.stop(canceled.message)
        return canceled._replace(drive=end.drive if end else None)

    def _canceled_before(self) -> Optional[GoalEnd]:
        ended = [(goal, goal.wait(timeout=0.0)) for goal in self._older]
        self._older = [goal for goal, end in ended if end is None]
        ends = [end for _, end in ended if end and end.canceled and not end.replaced]
        return ends[0] if ends else None


# Nearer to the goal than this there are no new plans (m): they would only disturb the arrival.
NEAR = 0.1
# So long (s) no plan has to succeed before it is worth a word: a start that is blocked for a
# moment, as beside an obstacle that is just being seen, is part of driving.
_UNUSUAL = 2.0


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
        self._failing_since: Optional[float] = None
        self._said: Optional[int] = None  # the outcome of the failure that was logged last

    def newer_plan(self, now: float, frequency: float, dist_to_goal: float) -> Optional[GoalEnd]:
        """A plan that succeeded, as soon as there is one; never waits.

        Args:
            now: time (s); it may jump back.
            frequency: of new plans (Hz); 0: none.
            dist_to_goal: m.
        """
        if self._plan is not None:
            end = self._plan.wait(timeout=0.0)
            if end is None:
                return None
            self._plan = None
            self._note(end, now)
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
            plan.stop(reason)

    def _note(self, end: GoalEnd, now: float) -> None:
        if end.succeeded:
            if self._said is not None:
                self._log("planning succeeds again")
            self._failing_since = self._said = None
            return
        if self._failing_since is None or now < self._failing_since:
            self._failing_since = now
        # Plans come every second, and fail for the same reason then: once is enough.
        if now - self._failing_since >= _UNUSUAL and end.outcome != self._said:
            self._said = end.outcome
            self._log(f"no new plan, the robot follows the old one: {end.message} ({end.outcome})")
