"""Outcomes of the actions: the constants of ``mbf_msgs/…Result``, as enumerations."""

from enum import IntEnum
from typing import Any

from mbf_msgs.msg import ExePathResult, GetPathResult, MoveBaseResult, RecoveryResult


def _outcomes(name: str, result: Any) -> Any:
    """The constants of a result message; its .action file says when each of them is given."""
    constants = {key: value for key, value in vars(result).items() if key.isupper()}
    return IntEnum(name, constants, module=__name__)


GetPathOutcome = _outcomes("GetPathOutcome", GetPathResult)
"""How a plan ended: SUCCESS = 0, FAILURE = 50, CANCELED, INVALID_START, INVALID_GOAL, ...

0 to 9 are successes (1 to 9 a planner's own), 71 to 99 a planner's own failures.
"""
ExePathOutcome = _outcomes("ExePathOutcome", ExePathResult)
"""How driving along a path goes, or ended: SUCCESS = 0, FAILURE = 100, CANCELED, NO_VALID_CMD, ...

0 to 9 are successes (1 to 9 a controller's own), 121 to 149 a controller's own failures.
"""
RecoveryOutcome = _outcomes("RecoveryOutcome", RecoveryResult)
"""How a recovery behavior ended: SUCCESS = 0, FAILURE = 150, CANCELED, PAT_EXCEEDED, ...

0 to 9 are successes (1 to 9 a behavior's own), 171 to 199 a behavior's own failures.
"""
MoveBaseOutcome = _outcomes("MoveBaseOutcome", MoveBaseResult)
"""How going to a goal ended; besides these, the outcomes of planning, driving and recovery."""

FIRST_ERROR = 10
PLANNER_ERRORS = range(71, 100)


class NotReady(Exception):
    """Raised where a goal cannot be begun: what it needs is not there, or is no good."""

    def __init__(self, kind: str, message: str) -> None:
        """
        Args:
            kind: the name of an outcome, such as TF_ERROR; CANCELED: who waited was canceled.
            message: one sentence for people.
        """
        super().__init__(message)
        self.kind = kind
        self.message = message


def is_success(outcome: int) -> bool:
    """Whether an outcome is one of the successes."""
    return 0 <= outcome < FIRST_ERROR


# How the ends of goals begin that a newer one of their slot took over from, or took the place of.
TAKEN_OVER = "Goal preempted by a new plan"
REPLACED = "a newer goal took slot"


def may_change_by_itself(outcome: int) -> bool:
    """Whether asking again, with the same map and poses, may end otherwise.

    A start off the map is still off the map a moment later: such goals are answered at once
    instead of being retried until the patience is gone. NO_PATH_FOUND is not judged here: that
    depends on the map.
    """
    passing = (GetPathOutcome.FAILURE, GetPathOutcome.TF_ERROR, GetPathOutcome.NOT_INITIALIZED)
    return outcome in passing or outcome in PLANNER_ERRORS
