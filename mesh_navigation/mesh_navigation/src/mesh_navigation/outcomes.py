"""Outcomes of planning, as plain numbers for code that knows no ROS.

The values are the constants of ``mbf_msgs/GetPathResult``; a test compares the two.
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


FIRST_ERROR = 10
PLANNER_ERRORS = range(71, 100)


def is_success(outcome: int) -> bool:
    """Whether an outcome is one of the successes."""
    return 0 <= outcome < FIRST_ERROR


def may_change_by_itself(outcome: int) -> bool:
    """Whether asking again, with the same map and poses, may end otherwise.

    A start off the map is still off the map a moment later: such goals are answered at once
    instead of being retried until the patience is gone.
    """
    passing = (GetPathOutcome.FAILURE, GetPathOutcome.TF_ERROR, GetPathOutcome.NOT_INITIALIZED)
    return outcome in passing or outcome in PLANNER_ERRORS
