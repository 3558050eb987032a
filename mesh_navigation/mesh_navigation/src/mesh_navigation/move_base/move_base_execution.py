"""Going to a goal: plan, drive, and recover where one of them fails. No ROS in here."""

from typing import Any, Callable, List, Mapping, Optional, Sequence, Set

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.clock import Clock
from mesh_navigation.base.outcomes import (
    ExePathOutcome,
    GetPathOutcome,
    MoveBaseOutcome,
    is_success,
)
from mesh_navigation.execution.drive_watches import OscillationWatch
from mesh_navigation.move_base.move_base_drive import Relay, Replanning
from mesh_navigation.move_base.sub_goals import (
    GoalEnd,
    MoveBaseOver,
    SubActions,
    SubGoal,
    checked,
    ended,
)

DRIVE = "exe_path"
# Between two looks at plans and progress (s, of the computer's clock).
POLL = 0.02
# Getting on is at least this much (m): what a robot that stands is measured to move is not.
SMALLEST_STEP = 0.05
# What recovery behaviors are tried for.
PLANNING, DRIVING = "planning", "driving"


class RecoveryChain:
    """Behaviors in their order, each once; from the first again when the triggers are overcome.

    Triggers are kept apart: a plan that is found again does not help a robot that still gets
    nowhere, so that the two taking turns come to an end too.
    """

    def __init__(self, behaviors: Sequence[str]) -> None:
        self._behaviors = list(behaviors)
        self._tried = 0
        self._triggers: Set[str] = set()

    @property
    def tried(self) -> List[str]:
        """Those that were tried since the last start."""
        return self._behaviors[: self._tried]

    @property
    def exhausted(self) -> bool:
        """Whether there is none left."""
        return self._tried >= len(self._behaviors)

    def next(self, trigger: str) -> Optional[str]:
        """The behavior to try for a trigger; None if there is none left."""
        self._triggers.add(trigger)
        if self.exhausted:
            return None
        self._tried += 1
        return self._behaviors[self._tried - 1]

    def overcome(self, trigger: str) -> bool:
        """A trigger is over. Returns whether the chain starts anew, now that the last one is."""
        if trigger not in self._triggers:
            return False
        self._triggers.discard(trigger)
        if self._triggers:
            return False
        self._tried = 0
        return True


FINAL = frozenset(
    (
        GetPathOutcome.TF_ERROR,
        GetPathOutcome.NOT_INITIALIZED,
        GetPathOutcome.INVALID_PLUGIN,
        GetPathOutcome.INTERNAL_ERROR,
        GetPathOutcome.OUT_OF_MAP,
        GetPathOutcome.MAP_ERROR,
        GetPathOutcome.STOPPED,
        ExePathOutcome.INVALID_PATH,
        ExePathOutcome.TF_ERROR,
        ExePathOutcome.NOT_INITIALIZED,
        ExePathOutcome.INVALID_PLUGIN,
        ExePathOutcome.INTERNAL_ERROR,
        ExePathOutcome.STOPPED,
    )
)
"""Failures that no recovery behavior can change. INVALID_GOAL is none of them: what is on a goal
may go away, and goals off the map do not come this far. Where it stays, the plan is lasting."""


class MoveBaseExecution:
    """One goal. ``run`` is called in the thread that waits for the answer."""

    def __init__(
        self,
        actions: SubActions,
        clock: Clock,
        values: Callable[[], Mapping[str, Any]],
        behaviors: Sequence[str],
        log: Callable[[str], None] = lambda message: None,
        localized: Callable[[], Optional[int]] = lambda: 0,
    ) -> None:
        """
        Args:
            actions: sends the sub-goals.
            clock: for the frequency of plans and for oscillation.
            values: parameters of the server, of now.
            behaviors: recovery behaviors in their order.
            log: gets sentences for people, about what is not as it should be.
            localized: how often the robot has been localized again after it was not; None while it
                is not. After that it may be elsewhere, and gets another plan.
        """
        self._actions = actions
        self._clock = clock
        self._values = values
        self._log = log
        self._localized = localized
        self._chain = RecoveryChain(behaviors)

    def run(self, cancellation: Cancellation) -> GoalEnd:
        """Go to the goal; returns when the robot stands there, or it has ended otherwise."""
        try:
            while True:
                plan = ended(self._actions.plan(), "get_path", cancellation)
                if not plan.succeeded:
                    self._recover(PLANNING, plan, cancellation)
                    continue
                self._overcome(PLANNING, "has a plan")
                drive = self._drive(plan.path, cancellation)
                if drive is None:
                    self._log("the robot was not localized meanwhile, and gets another plan")
                    continue
                if drive.succeeded:
                    return drive
                self._recover(DRIVING, drive, cancellation)
        except MoveBaseOver as over:
            return over.end

    def _drive(self, path: Any, cancellation: Cancellation) -> Optional[GoalEnd]:
        """Drive; returns how it ended: with success, or why the robot cannot go on; None where it
        was not localized meanwhile, so that nobody knows where on the path it is.

        Raises:
            MoveBaseOver: see `mesh_navigation.move_base.sub_goals.ended`.
        """
        oscillation = OscillationWatch()
        replanning = Replanning(self._actions, self._clock.now(), self._log)
        times = self._localized()
        drive = Relay(self._actions, path)
        try:
            while True:
                end = drive.wait(cancellation, POLL)
                is_elsewhere = self._localized() not in (None, times)
                if end is not None or cancellation.canceled:
                    end = _as_oscillation(checked(end, drive, DRIVE, cancellation))
                    return None if is_elsewhere and not end.succeeded else end
                if is_elsewhere:
                    end = _stopped(drive, "the robot may be elsewhere than it was believed to be")
                    return end if end.succeeded else None
                progress = drive.progress
                if progress is None:
                    oscillation.restart()  # A robot that stands without a pose does not oscillate.
                    continue
                now, values = self._clock.now(), self._values()
                getting_on = max(SMALLEST_STEP, values["oscillation_distance"])
                if drive.distance() >= getting_on and is_success(progress.outcome):
                    self._overcome(DRIVING, "gets on")
                fault = oscillation.fault(progress.pose, now, values)
                if fault:
                    return _end_oscillation(drive, fault)
                frequency = values["planner_frequency"]
                plan = replanning.newer_plan(now, frequency, progress.dist_to_goal)
                if plan is not None:
                    drive.follow(plan.path)
        except MoveBaseOver:
            raise
        except Exception:  # Whatever it is, the robot does not go on alone.
            drive.stop("move_base failed")
            raise
        finally:
            replanning.end("the drive has ended")

    def _overcome(self, trigger: str, what: str) -> None:
        tried = ", ".join(self._chain.tried)
        if self._chain.overcome(trigger):
            self._log(f"the robot {what} again, after {tried}")

    def _recover(self, trigger: str, failure: GoalEnd, cancellation: Cancellation) -> None:
        """Run the next behavior.

        Raises:
            MoveBaseOver: there is nothing that could help.
        """
        is_final = failure.outcome in FINAL or failure.lasting
        if is_final or not self._values()["recovery_enabled"]:
            raise MoveBaseOver(failure)
        tried = self._chain.tried
        name = self._chain.next(trigger)
        if name is None:
            raise MoveBaseOver(_in_vain(failure, tried))
        self._log(f"{trigger} failed: {failure.message} ({failure.outcome}); trying {name}")
        times = self._localized()
        end = ended(self._actions.recover(name), f"recovery {name}", cancellation)
        if not end.succeeded:
            self._log(f"recovery {name} failed: {end.message} ({end.outcome})")
            if self._chain.exhausted and self._localized() == times:
                raise MoveBaseOver(_in_vain(failure, self._chain.tried))


def _stopped(drive: SubGoal, reason: str) -> GoalEnd:
    """How a drive ends that is stopped for a reason."""
    end = drive.stop(reason)
    if end is None:
        # Whatever is done next, two would command the robot.
        message = f"{reason}; {DRIVE} does not end"
        raise MoveBaseOver(GoalEnd(MoveBaseOutcome.INTERNAL_ERROR, message))
    return end


def _end_oscillation(drive: SubGoal, fault: str) -> GoalEnd:
    end = _stopped(drive, fault)
    if end.succeeded:
        return end
    return GoalEnd(MoveBaseOutcome.OSCILLATION, fault, drive=end.drive)


def _as_oscillation(end: GoalEnd) -> GoalEnd:
    # exe_path looks for oscillation by the same rule: who is first makes no difference to clients.
    if end.outcome == ExePathOutcome.OSCILLATION:
        return end._replace(outcome=int(MoveBaseOutcome.OSCILLATION))
    return end


def _in_vain(end: GoalEnd, tried: Sequence[str]) -> GoalEnd:
    """What led to the recovery, not what came of that, is what the goal failed for."""
    if not tried:
        return end
    return end._replace(message=f"{end.message}; recovery did not help: {', '.join(tried)}")
