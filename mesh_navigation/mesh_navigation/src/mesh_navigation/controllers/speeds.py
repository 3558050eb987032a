"""Speeds that can be kept: limits, accelerations, distances to stop."""

import math


def braking_speed(distance: float, deceleration: float, period: float) -> float:
    """The highest speed at which one still stops within a distance.

    The speed holds for one period, then falls by ``deceleration * period`` each period until it is
    0: m speeds v, v - a T, v - 2 a T and so on lead m v T - a T^2 m (m - 1) / 2 far. The same for
    angles.

    Args:
        distance: m, or rad.
        deceleration: m/s^2, or rad/s^2, above 0.
        period: of commands, s, above 0.
    """
    if not distance > 0.0:
        return 0.0
    if math.isinf(distance):
        return math.inf
    step = deceleration * period
    count = max(math.ceil((math.sqrt(1 + 8 * distance / (step * period)) - 1) / 2), 1)
    return (distance / period + step * count * (count - 1) / 2) / count


def stopping_distance(speed: float, deceleration: float, period: float) -> float:
    """What is driven until it stands: one period at this speed, then braking (m)."""
    return speed * period + speed * speed / (2 * deceleration)


def limited(value: float, limit: float) -> float:
    """Within -limit to limit."""
    return max(-limit, min(limit, value))


def approached(target: float, present: float, step: float) -> float:
    """As near to a target as one step from the present value allows."""
    return present + limited(target - present, step)
