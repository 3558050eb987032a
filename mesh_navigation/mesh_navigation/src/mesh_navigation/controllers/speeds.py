"""Speeds that can be kept: limits, accelerations, distances to stop."""

import math


def braking_speed(distance: float, deceleration: float, period: float) -> float:
    """The highest speed at which one still stops within a distance.

    The speed holds for one period, then falls by ``deceleration * period`` each period: from v in n
    = v / (deceleration * period) periods, on a way of v period (n + 1) / 2. Never more than what
    arrives with the next period. The same for angles.

    Args:
        distance: m, or rad.
        deceleration: m/s^2, or rad/s^2, above 0.
        period: of commands, s, above 0.
    """
    if not distance > 0.0:
        return 0.0
    half_step = deceleration * period / 2
    speed = math.sqrt(half_step * half_step + 2 * deceleration * distance) - half_step
    return min(speed, distance / period)


def stopping_distance(speed: float, deceleration: float, period: float) -> float:
    """What is driven until it stands: one period at this speed, then braking (m)."""
    return speed * period + speed * speed / (2 * deceleration)


def limited(value: float, limit: float) -> float:
    """Within -limit to limit."""
    return max(-limit, min(limit, value))


def approached(target: float, present: float, step: float) -> float:
    """As near to a target as one step from the present value allows."""
    return present + limited(target - present, step)
