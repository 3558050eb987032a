"""Velocities within limits, and no faster change to more of them than an acceleration allows."""

import math
from typing import NamedTuple, Tuple

from mesh_navigation.base.robot import STOP, Velocity

# Periods of control whose change of velocity may come at once: commands do not come evenly.
SLACK = 2.0


class VelocityLimits(NamedTuple):
    """The most that passes."""

    max_lin_velocity: float
    """m/s."""
    max_ang_velocity: float
    """rad/s."""
    max_lin_acceleration: float
    """m/s^2, > 0."""
    max_ang_acceleration: float
    """rad/s^2, > 0."""


class VelocityBounds:
    """Bounds one command after the other. Slower is never delayed: only what gains speed."""

    def __init__(self, limits: VelocityLimits) -> None:
        self._limits = limits
        self._last = STOP
        self._time = -math.inf
        self._credit = 0.0  # s of acceleration that have not been used yet

    def bounded(self, wanted: Velocity, time: float, period: float) -> Velocity:
        """What may be sent of a command.

        Args:
            wanted: the command; what is not finite becomes `STOP`.
            time: of now (s); a time that jumps back gives nothing.
            period: from one command to the next, as it should be (s).
        """
        if not wanted.is_finite:
            wanted = STOP
        elapsed, self._time = max(0.0, time - self._time), time
        self._credit = min(self._credit + elapsed, SLACK * period)
        limits, last = self._limits, self._last
        wanted = self._slowed(wanted)
        linear, angular = limits.max_lin_acceleration, limits.max_ang_acceleration
        found = [
            _approached(*values, self._credit)
            for values in zip(last, wanted, (linear, linear, angular))
        ]
        self._credit -= max(seconds for _, seconds in found)
        self._last = Velocity(*(value for value, _ in found))
        return self._last

    def stop(self) -> Velocity:
        """Standing, which is never delayed."""
        self._last = STOP
        return STOP

    def _slowed(self, wanted: Velocity) -> Velocity:
        """Along the same curve, as fast as the limits allow."""
        limits, speed = self._limits, math.hypot(wanted.x, wanted.y)
        share = 1.0
        if speed > limits.max_lin_velocity:
            share = limits.max_lin_velocity / speed
        if abs(wanted.yaw) * share > limits.max_ang_velocity:
            share = limits.max_ang_velocity / abs(wanted.yaw)
        return wanted if share == 1.0 else Velocity(*(share * value for value in wanted))


def _approached(
    last: float, wanted: float, acceleration: float, credit: float
) -> Tuple[float, float]:
    """Of one axis, the value that may be sent, and for how many seconds it gains speed."""
    begin = last if last * wanted > 0.0 else 0.0  # To turn round it stands first, at once.
    gain = abs(wanted) - abs(begin)
    if gain <= 0.0:
        return wanted, 0.0
    if gain <= acceleration * credit:
        return wanted, gain / acceleration
    return math.copysign(abs(begin) + acceleration * credit, wanted), credit
