"""One drive to the goal: along a plan, and those that replace it meanwhile."""

from typing import Any, Callable, Mapping, Optional

import numpy as np

from mesh_navigation.cancellation import Cancellation
from mesh_navigation.clock import Clock
from mesh_navigation.drive_watches import OscillationWatch
from mesh_navigation.move_base_end import MoveBaseEnd, Over, checked, stopped
from mesh_navigation.outcomes import ExePathOutcome, MoveBaseOutcome, is_success
from mesh_navigation.pose import Pose
from mesh_navigation.relay import Relay
from mesh_navigation.replanning import Replanning
from mesh_navigation.sub_goals import Progress, SubActions, SubEnd, SubGoal, SubState

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

    def run(self, path: Any, cancellation: Cancellation) -> SubEnd:
        """Drive; returns how it ended: with success, or why the robot cannot go on.

        Raises:
            Over: see `mesh_navigation.move_base_end.ended`.
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
            stopped(drive, "move_base failed")
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


def _end_oscillation(drive: SubGoal, fault: str) -> SubEnd:
    end = stopped(drive, "the robot oscillates")
    if end is None:
        # Whatever is done next, two would command the robot.
        message = f"{fault}; {WHAT} does not end"
        raise Over(MoveBaseEnd(MoveBaseOutcome.INTERNAL_ERROR, message))
    if end.succeeded:
        return end
    return SubEnd(SubState.ABORTED, MoveBaseOutcome.OSCILLATION, fault, drive=end.drive)


def _as_oscillation(end: SubEnd) -> SubEnd:
    # exe_path looks for oscillation by the same rule: who is first makes no difference to clients.
    if end.outcome == ExePathOutcome.OSCILLATION:
        return end._replace(outcome=int(MoveBaseOutcome.OSCILLATION))
    return end
