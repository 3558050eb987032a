"""Velocities within limits."""

import math
import random

import pytest

from mesh_navigation.base.robot import STOP, Velocity
from mesh_navigation.velocity_guard.velocity_bounds import SLACK, VelocityBounds, VelocityLimits

LIMITS = VelocityLimits(2.0, 1.0, 4.0, 8.0)
PERIOD = 0.05


def bounds_at(velocity):
    """That have just sent a velocity within the limits."""
    bounds = VelocityBounds(LIMITS._replace(max_lin_acceleration=1e9, max_ang_acceleration=1e9))
    bounds.bounded(velocity, 0.0, PERIOD)
    bounds._limits, bounds._credit = LIMITS, 0.0
    return bounds


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("axis", ["x", "y", "yaw"])
def test_what_is_not_finite_is_a_stop(axis, number):
    bounds = bounds_at(Velocity(1.0, 0.0, 0.5))
    assert bounds.bounded(Velocity(1.0)._replace(**{axis: number}), 1.0, PERIOD) == STOP


@pytest.mark.parametrize(
    "wanted, found",
    [
        (Velocity(2.0, 0.0, 1.0), (2.0, 0.0, 1.0)),
        (Velocity(4.0, 0.0, 0.5), (2.0, 0.0, 0.25)),  # on the same curve
        (Velocity(1.0, 0.0, -4.0), (0.25, 0.0, -1.0)),
        (Velocity(3.0, -4.0, 0.0), (1.2, -1.6, 0.0)),
        (Velocity(1e308, 1e308, 1e308), (1.0, 1.0, 1.0)),
        (Velocity(1.7e308, 1.7e308, 0.0), (0.0, 0.0, 0.0)),  # beyond all numbers
    ],
)
def test_too_fast(wanted, found):
    free = LIMITS._replace(max_lin_acceleration=1e9, max_ang_acceleration=1e9)
    assert VelocityBounds(free).bounded(wanted, 0.0, PERIOD) == pytest.approx(found)


def test_slower_comes_at_once():
    """Each axis by itself; to turn round the robot stands first."""
    for wanted in (STOP, Velocity(0.5, 0.2, 0.3), Velocity(0.1)):
        assert bounds_at(Velocity(1.0, 0.5, 0.5)).bounded(wanted, 0.0, PERIOD) == wanted
    assert bounds_at(Velocity(1.0)).bounded(Velocity(-1.0), 0.0, PERIOD) == STOP
    assert bounds_at(Velocity(1.0)).bounded(Velocity(-1.0), 0.01, PERIOD).x == pytest.approx(-0.04)


def test_from_standing():
    bounds, found = VelocityBounds(LIMITS), []
    for cycle in range(12):
        found.append(bounds.bounded(Velocity(2.0, 0.0, 0.0), cycle * PERIOD, PERIOD).x)
    first = SLACK * PERIOD * 4.0
    steps = [min(2.0, first + 4.0 * PERIOD * cycle) for cycle in range(12)]
    assert found == pytest.approx(steps)


def test_speed_is_not_gained_faster_over_irregular_periods():
    """However commands come, in bursts or with pauses, and whichever way time jumps."""
    choose, bounds, now, sent = random.Random(1), VelocityBounds(LIMITS), 0.0, [(0.0, 0.0)]
    for _ in range(3000):
        now += choose.choice((0.0, 0.0, 1e-4, 0.01, 0.05, 0.2))
        wanted = choose.choice((-2.0, 0.5, 2.0, 2.0, 2.0, 2.0))
        sent.append((now, bounds.bounded(Velocity(wanted), now, PERIOD).x))
    for first in range(0, len(sent), 7):
        begin, speed = sent[first]
        for time, later in sent[first : first + 60]:
            if abs(later) <= abs(speed) and later * speed >= 0.0:
                begin, speed = time, later  # it braked: to gain begins here
                continue
            gained = abs(later) - (abs(speed) if later * speed > 0.0 else 0.0)
            assert gained <= 4.0 * (time - begin + SLACK * PERIOD) + 1e-9


def test_a_time_that_jumps_back_gives_nothing():
    bounds = bounds_at(Velocity(1.0))
    assert bounds.bounded(Velocity(2.0), -100.0, PERIOD).x == 1.0
    assert bounds.bounded(Velocity(2.0), -99.99, PERIOD).x == pytest.approx(1.04)


def test_after_a_stop_it_gains_speed_from_zero():
    bounds = bounds_at(Velocity(2.0))
    assert bounds.stop() == STOP
    assert bounds.bounded(Velocity(2.0), 0.01, PERIOD).x == pytest.approx(0.04)
