"""What a controller answers, checked before a robot obeys it."""

from typing import Any, Callable

import numpy as np

from mesh_map.errors import one_line

from mesh_navigation.controller import Command, ControlFailure
from mesh_navigation.outcomes import ExePathOutcome, is_success
from mesh_navigation.robot import STOP, Velocity

FINAL = frozenset(
    (
        ExePathOutcome.CANCELED,
        ExePathOutcome.INVALID_PATH,
        ExePathOutcome.NOT_INITIALIZED,
        ExePathOutcome.INTERNAL_ERROR,
        ExePathOutcome.MAP_ERROR,
    )
)
"""Failures that another cycle does not change."""


def checked_command(ask: Callable[[], Any]) -> Command:
    """The command that a controller returns, or what is wrong with it; never raises.

    The velocity of a failure is zero, its message says something. A velocity that is not finite is
    NO_VALID_CMD; an exception, or anything that is no command, is INTERNAL_ERROR.
    """
    try:
        command = ask()
        if not isinstance(command, Command):
            return _fault(f"it returned {type(command).__name__} instead of a Command")
        outcome = command.outcome
        if not isinstance(outcome, (int, np.integer)) or not 0 <= outcome < 256:
            return _fault(f"its outcome is {outcome!r}, not a number from 0 to 255")
        outcome, message = int(outcome), one_line(command.message)
        if not is_success(outcome):
            return Command(outcome, message or f"the controller reported {outcome_text(outcome)}")
        x, y, yaw = map(float, command.velocity)
    except ControlFailure as failure:
        refused = Command(failure.outcome, failure.message)
        return checked_command(lambda: refused)
    except (Exception, SystemExit) as error:  # A plugin may raise anything; its goal is answered.
        return _fault(f"{type(error).__name__}: {error}")
    velocity = Velocity(x, y, yaw)
    if not velocity.is_finite:
        numbers = ", ".join(f"{number:g}" for number in velocity)
        return Command(
            ExePathOutcome.NO_VALID_CMD,
            f"the controller's velocity (x, y, yaw) = ({numbers}) is not finite",
        )
    return Command(outcome, message, velocity)


def outcome_text(outcome: int) -> str:
    """``MISSED_PATH (108)``, or the number alone of an outcome without a name."""
    try:
        return f"{ExePathOutcome(outcome).name} ({outcome})"
    except ValueError:
        return str(outcome)


def _fault(what: str) -> Command:
    text = one_line(f"the controller is at fault: {what}")
    return Command(ExePathOutcome.INTERNAL_ERROR, text, STOP)
