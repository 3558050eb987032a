"""Outcomes of the actions, as plain numbers for code that knows no ROS.

The values are the constants of ``mbf_msgs/…Result``; a test compares the two.
"""

from enum import IntEnum


class GetPathOutcome(IntEnum):
    """How a plan ended.

    0 to 9 are successes (1 to 9 a planner's own), 71 to 99 a planner's own failures.
    """

    SUCCESS = 0
    FAILURE = 50
    CANCELED = 51
    INVALID_START = 52
    INVALID_GOAL = 53
    NO_PATH_FOUND = 54
    PAT_EXCEEDED = 55
    EMPTY_PATH = 56
    TF_ERROR = 57
    NOT_INITIALIZED = 58
    INVALID_PLUGIN = 59
    INTERNAL_ERROR = 60
    OUT_OF_MAP = 61
    MAP_ERROR = 62
    STOPPED = 63


class ExePathOutcome(IntEnum):
    """How driving along a path goes, or ended.

    0 to 9 are successes (1 to 9 a controller's own), 121 to 149 a controller's own failures.
    """

    SUCCESS = 0
    FAILURE = 100
    CANCELED = 101
    NO_VALID_CMD = 102
    PAT_EXCEEDED = 103
    COLLISION = 104
    OSCILLATION = 105
    ROBOT_STUCK = 106
    MISSED_GOAL = 107
    MISSED_PATH = 108
    BLOCKED_PATH = 109
    INVALID_PATH = 110
    TF_ERROR = 111
    NOT_INITIALIZED = 112
    INVALID_PLUGIN = 113
    INTERNAL_ERROR = 114
    OUT_OF_MAP = 115
    MAP_ERROR = 116
    STOPPED = 117


class RecoveryOutcome(IntEnum):
    """How a recovery behavior ended.

    0 to 9 are successes (1 to 9 a behavior's own), 171 to 199 a behavior's own failures.
    """

    SUCCESS = 0
    FAILURE = 150
    CANCELED = 151
    PAT_EXCEEDED = 152
    TF_ERROR = 153
    NOT_INITIALIZED = 154
    INVALID_PLUGIN = 155
    INTERNAL_ERROR = 156
    STOPPED = 157
    IMPASSABLE = 158


class MoveBaseOutcome(IntEnum):
    """How going to a goal ended; besides these, the outcomes of planning, driving and recovery."""

    SUCCESS = 0
    FAILURE = 10
    CANCELED = 11
    COLLISION = 12
    OSCILLATION = 13
    START_BLOCKED = 14
    GOAL_BLOCKED = 15
    TF_ERROR = 16
    INTERNAL_ERROR = 17
    PLAN_FAILURE = 50
    CTRL_FAILURE = 100


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
    instead of being retried until the patience is gone.
    """
    passing = (GetPathOutcome.FAILURE, GetPathOutcome.TF_ERROR, GetPathOutcome.NOT_INITIALIZED)
    return outcome in passing or outcome in PLANNER_ERRORS
