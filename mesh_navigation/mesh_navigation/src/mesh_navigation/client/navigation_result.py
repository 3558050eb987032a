"""How a goal ended, as a client sees it."""

from typing import Any, NamedTuple

from mesh_navigation.base.outcomes import (
    FIRST_ERROR,
    ExePathOutcome,
    GetPathOutcome,
    MoveBaseOutcome,
    RecoveryOutcome,
    is_success,
)

# The errors of each action: beyond the hundred of get_path and exe_path, move_base passes them on.
_RANGES = (
    (range(FIRST_ERROR, 50), MoveBaseOutcome, "MOVE_BASE"),
    (range(50, 100), GetPathOutcome, "PLANNER"),
    (range(100, 150), ExePathOutcome, "CONTROLLER"),
    (range(150, 200), RecoveryOutcome, "RECOVERY"),
)


class NavigationError(Exception):
    """A goal did not get to its end: there is no server, or it has ended. The text says more."""


class NavigationResult(NamedTuple):
    """The answer of the server."""

    outcome: int
    """The number, as in ``mbf_msgs/…Result``."""
    message: str
    """Why, with numbers."""
    succeeded: bool
    details: Any
    """The message of the action: ``final_pose``, ``path``, … as mbf_msgs has them."""

    @property
    def name(self) -> str:
        """The outcome's name, such as NO_PATH_FOUND."""
        return outcome_name(self.outcome)

    def __str__(self) -> str:
        return f"{self.name} ({self.outcome}): {self.message}"


def outcome_name(outcome: int) -> str:
    """The name of an outcome of any action; a plugin's own are called such as CONTROLLER_ERROR."""
    if is_success(outcome):
        return "SUCCESS"
    for numbers, names, action in _RANGES:
        if outcome in numbers:
            known = {int(value): value.name for value in names}
            return known.get(outcome, f"{action}_ERROR")
    return "UNKNOWN"


def canceled_outcome(action: str) -> int:
    """The outcome CANCELED of an action: get_path, exe_path, recovery or move_base."""
    kinds = {"get_path": GetPathOutcome, "exe_path": ExePathOutcome, "recovery": RecoveryOutcome}
    return int(kinds.get(action, MoveBaseOutcome).CANCELED)
