"""What a simulated base makes of velocity commands: limits, and accelerations that take time."""

import math
from typing import NamedTuple, Tuple

from mesh_navigation.base.robot import STOP, Velocity


class BaseLimits(NamedTuple):
    """What a base can do; infinite: no limit."""

    speed: float = 1.5
    """Ahead and back (m/s)."""
    side_speed: float = 0.0
    """To the left and to the right (m/s); 0 for wheels that cannot."""
    turn_speed: float = 3.0
    """To either side (rad/s)."""
    acceleration: float = 2.5
    """Of speed, when braking as well (m/s^2)."""
    turn_acceleration: float = 6.0
    """Of turn_speed (rad/s^2)."""

    def clipped(self, wish: Velocity) -> Velocity:
        """The nearest velocity within the limits; `STOP` for one that is not finite."""
        if not wish.is_finite:
            return STOP
        limits = (self.speed, self.side_speed, self.turn_speed)
        return Velocity(*(max(-limit, min(limit, value)) for value, limit in zip(wish, limits)))


class Wheels:
    """The velocity of a base."""

    def __init__(self, limits: BaseLimits = BaseLimits()) -> None:
        for name, limit in zip(BaseLimits._fields, limits):
            if not limit >= 0:
                raise ValueError(f"{name} of a base is {limit}, but has to be >= 0")
        self.limits = limits
        self.velocity = STOP

    def advance(self, command: Velocity, seconds: float) -> Velocity:
        """Follow a command for a while.

        Returns:
            The mean velocity of this time, exact for constant accelerations.
        """
        rates = (self.limits.acceleration, self.limits.acceleration, self.limits.turn_acceleration)
        wish = self.limits.clipped(command)
        if wish == self.velocity:
            return wish
        parts = [_ramp(*part, seconds) for part in zip(self.velocity, wish, rates)]
        self.velocity = Velocity(*(end for end, _ in parts))
        return Velocity(*(mean for _, mean in parts))

    def block(self) -> None:
        """Something is in the way: the speed is gone, not the turning."""
        self.velocity = Velocity(0.0, 0.0, self.velocity.yaw)


def _ramp(start: float, end: float, rate: float, seconds: float) -> Tuple[float, float]:
    """From a velocity towards another at a rate: what is reached, and the mean on the way."""
    needed = abs(end - start) / rate if rate > 0 else math.inf
    if start == end or needed == 0:
        return end, end
    if needed < seconds:
        return end, ((start + end) / 2 * needed + end * (seconds - needed)) / seconds
    reached = start + math.copysign(rate * seconds, end - start)
    return reached, (start + reached) / 2
