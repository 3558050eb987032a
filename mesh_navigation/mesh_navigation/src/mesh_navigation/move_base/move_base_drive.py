"""One drive to the goal: along a plan, and those that replace it meanwhile."""

from typing import Any, Callable, List, Mapping, Optional

import numpy as np

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import ExePathOutcome, MoveBaseOutcome, is_success
from mesh_navigation.base.pose import Pose
from mesh_navigation.execution.drive_watches import OscillationWatch
from mesh_navigation.move_base.sub_goals import (
    GoalEnd,
    Over,
    Progress,
    SubActions,
    SubGoal,
    checked,
)

WHAT = "exe_path"
# Between two looks at plans and progress (s, of the computer's clock).
POLL = 0.02
# Getting on is at least this much (m): what a robot that stands is measured to move is not.
SMALLEST_STEP = 0.05


class Drive:
    """Drives once, until the robot has arrived or does not get on."""

    def __init__(
        self,
        actions: SubActions,
        clock: Clock,
        values: Callable[[], Mapping[str, Any]],
        log: Callable[[str], None],
        on_got_on: Callable[[], None],
    ) -> None:
        """
        Args:
            actions: sends the sub-goals.
            clock: for the frequency of plans and for oscillation.
            values: parameters of the server, of now.
            log: gets sentences for people.
            on_got_on: called, perhaps often, once the robot has left where it began.
        """
        self._actions = actions
        self._clock = clock
        self._values = values
        self._log = log
        self._on_got_on = on_got_on

    def run(self, path: Any, cancellation: Cancellation) -> GoalEnd:
        """Drive; returns how it ended: with success, or why the robot cannot go on.

        Raises:
            Over: see `mesh_navigation.move_base.sub_goals.ended`.
        """
        latest = _Latest()  # of this drive: what comes late from another one is not of interest
        oscillation = OscillationWatch()
        replanning = Replanning(self._actions, self._clock.now(), self._log)
        drive = Relay(self._actions, path, latest.note)
        try:
            while True:
                end = drive.wait(cancellation, POLL)
                if end is not None or cancellation.canceled:
                    return _as_oscillation(checked(end, drive, WHAT, cancellation))
                progress = latest.progress
                if progress is None:
                    continue
                now, values = self._clock.now(), self._values()
                self._note_way(latest, progress, values["oscillation_distance"])
                fault = oscillation.fault(progress.pose, now, values)
                if fault:
                    return _end_oscillation(drive, fault)
                frequency = values["planner_frequency"]
                plan = replanning.newer_plan(now, frequency, progress.dist_to_goal)
                if plan is not None:
                    drive.follow(plan.path)
        except Over:
            raise
        except Exception:  # Whatever it is, the robot does not go on alone.
            drive.stop("move_base failed")
            raise
        finally:
            replanning.end("the drive has ended")

    def _note_way(self, latest: "_Latest", progress: Progress, distance: float) -> None:
        way = float(np.linalg.norm(progress.pose.position - latest.base.position))
        if way >= max(SMALLEST_STEP, distance) and is_success(progress.outcome):
            self._on_got_on()


class _Latest:
    """What is reported: the newest, and where the robot was first."""

    def __init__(self) -> None:
        self.progress: Optional[Progress] = None
        self.base: Pose

    def note(self, progress: Progress) -> None:
        if self.progress is None:
            self.base = progress.pose
        self.progress = progress


def _end_oscillation(drive: SubGoal, fault: str) -> GoalEnd:
    end = drive.stop("the robot oscillates")
    if end is None:
        # Whatever is done next, two would command the robot.
        message = f"{fault}; {WHAT} does not end"
        raise Over(GoalEnd(MoveBaseOutcome.INTERNAL_ERROR, message))
    if end.succeeded:
        return end
    return GoalEnd(MoveBaseOutcome.OSCILLATION, fault, drive=end.drive)


def _as_oscillation(end: GoalEnd) -> GoalEnd:
    # exe_path looks for oscillation by the same rule: who is first makes no difference to clients.
    if end.outcome == ExePathOutcome.OSCILLATION:
        return end._replace(outcome=int(MoveBaseOutcome.OSCILLATION))
    return end


class Relay(SubGoal):
    """A drive along a path, and along newer ones, each of which is a goal of its own.

    What ends is the newest. But somebody who cancels the drive just when the next one is sent means
    the robot: then the newest is canceled as well.
    """

    def __init__(
        self, actions: SubActions, path: Any, on_progress: Callable[[Progress], None]
    ) -> None:
        """
        Args:
            actions: sends the goals.
            path: the first one.
            on_progress: as in `SubActions.drive`.
        """
        self._actions = actions
        self._on_progress = on_progress
        self._older: List[SubGoal] = []
        self._newest = actions.drive(path, on_progress)

    def follow(self, path: Any) -> None:
        """Go on along a newer path."""
        self._older.append(self._newest)
        self._newest = self._actions.drive(path, self._on_progress)

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
            plan.stop(reason)

    def _note(self, end: GoalEnd) -> None:
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
