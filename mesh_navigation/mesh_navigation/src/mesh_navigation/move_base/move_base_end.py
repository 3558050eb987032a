"""How going to a goal ends, and how its sub-goals are brought to an end."""

from typing import Any, NamedTuple

from mesh_navigation.base.cancellation import Cancellation
from mesh_navigation.base.outcomes import MoveBaseOutcome
from mesh_navigation.move_base.sub_goals import SubEnd, SubGoal, SubState

# For a sub-goal to end after its cancel (s): its server answers after half a second whatever its
# plugin does, so this passes only where something is very wrong.
PATIENCE = 5.0


class MoveBaseEnd(NamedTuple):
    """How it ended."""

    outcome: int
    """A value of `MoveBaseOutcome`, or of the outcomes of planning, driving and recovery."""
    message: str
    """One sentence for people."""
    drive: Any = None
    """Where the drive ended that was the last sub-goal; None if that was none."""


class Over(Exception):
    """Raised where it ends without success."""

    def __init__(self, end: MoveBaseEnd) -> None:
        super().__init__(end.message)
        self.end = end


def ended(goal: SubGoal, what: str, cancellation: Cancellation) -> SubEnd:
    """Wait until a sub-goal has succeeded or failed.

    Args:
        goal: the sub-goal.
        what: what it is called in messages.
        cancellation: of the whole; cancels the sub-goal.

    Raises:
        Over: canceled, by ours or by somebody else, or rejected.
    """
    return checked(goal.wait(cancellation, None), goal, what, cancellation)


def checked(end: Any, goal: SubGoal, what: str, cancellation: Cancellation) -> SubEnd:
    """The end of a sub-goal that was waited for, None where a cancel ended the waiting.

    Raises:
        Over: as `ended`.
    """
    if cancellation.canceled:
        raise Over(_canceled(goal, what, cancellation.reason))
    if end.state in (SubState.CANCELED, SubState.REPLACED):
        # Someone wants the robot to stop: going on would be disobedience.
        message = f"{what} was canceled, not by move_base: {end.message}"
        raise Over(MoveBaseEnd(MoveBaseOutcome.CANCELED, message, end.drive))
    if end.state is SubState.REJECTED:
        raise Over(MoveBaseEnd(end.outcome, end.message, end.drive))
    return end


def _canceled(goal: SubGoal, what: str, reason: str) -> MoveBaseEnd:
    end = stopped(goal, reason)
    message = f"canceled during {what}: {reason}"
    if end is None:
        message += f"; {what} has not ended within {PATIENCE:g} s"
    return MoveBaseEnd(MoveBaseOutcome.CANCELED, message, end.drive if end else None)


def stopped(goal: SubGoal, reason: str) -> Any:
    """Cancel a sub-goal; its end, None if it does not come."""
    goal.cancel(reason)
    return goal.wait(Cancellation(), PATIENCE)
