"""Velocities slowed down until they lead over free ground."""

import math
from typing import Any, Mapping

from mesh_map.walk import SurfaceWalker

from mesh_navigation.controllers.carrot import Carrot
from mesh_navigation.controllers.foresight import free_arc
from mesh_navigation.controllers.ground import Ground
from mesh_navigation.controllers.speeds import stopping_distance
from mesh_navigation.controllers.standing import Standing
from mesh_navigation.controllers.steering import SHARP, turning_speed
from mesh_navigation.robot import Velocity

CLEARANCE = 0.05  # m that an arc has to be free beyond where the robot would stand
_SHARES = 1.0, 0.7, 0.4, 0.2, 0.1  # of a speed, until its arc is free
_STRAIGHT = 0.02  # rad; an arc to what is less to the side is the straight line to it


def on_free_ground(
    wanted: Velocity,
    walker: SurfaceWalker,
    ground: Ground,
    standing: Standing,
    carrot: Carrot,
    values: Mapping[str, Any],
    period: float,
) -> Velocity:
    """The fastest share of a velocity whose arc is free until the robot could stand; a turn on the
    spot where there is none.

    Args:
        wanted: that velocity, towards the carrot.
        walker: over the surface.
        ground: where it is blocked.
        standing: where the robot is.
        carrot: beyond it, nothing is looked at.
        values: of the parameters.
        period: of commands (s).
    """
    if wanted.x <= 0.0 or abs(carrot.angle) < _STRAIGHT:
        return wanted
    for share in _SHARES:
        speed = share * wanted.x
        length = stopping_distance(speed, values["max_lin_acceleration"], period) + CLEARANCE
        length = min(length, _arc_length(carrot))
        if free_arc(walker, ground, standing, wanted.yaw / speed, length) is None:
            return wanted._replace(x=speed)
    return Velocity(yaw=turning_speed(carrot.angle, values, period))


def _arc_length(carrot: Carrot) -> float:
    """From the robot to the carrot (m)."""
    angle = min(abs(carrot.angle), SHARP)
    return carrot.distance * angle / math.sin(angle) if angle > 0.0 else carrot.distance
