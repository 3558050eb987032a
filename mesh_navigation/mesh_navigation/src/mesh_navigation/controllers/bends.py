"""How fast a robot may be, so that it can still brake for the bends of its way."""

import math
from typing import Any, Mapping

import numpy as np

from mesh_navigation.controllers.speeds import braking_speed
from mesh_navigation.controllers.steering import speed_towards
from mesh_navigation.controllers.vector3 import Vector3
from mesh_navigation.controllers.way import Way

_MOST = 32  # places that are looked at


def speed_before_bends(
    way: Way, up: Vector3, farthest: float, values: Mapping[str, Any], period: float
) -> float:
    """The highest speed from which one can brake to that of each bend of the way (m/s).

    Those nearer than lookahead_distance are left out: the angle to the carrot tells of them.

    Args:
        way: ahead of the robot.
        up: from the surface.
        farthest: m, to where bends count: the robot can stop before all others.
        values: of the parameters.
        period: of commands (s).
    """
    look = values["lookahead_distance"]
    farthest = min(farthest, way.length - look / 2)
    if farthest <= look:
        return math.inf
    places = np.linspace(look, farthest, min(math.ceil((farthest - look) / (look / 4)) + 1, _MOST))
    before = _level(way, places - look / 2, places, up)
    behind = _level(way, places, places + look / 2, up)
    angles = np.arccos(np.clip(np.einsum("ij,ij->i", before, behind), -1.0, 1.0))
    brakes = values["max_lin_acceleration"]
    return min(
        math.hypot(speed_towards(angle, look, values), braking_speed(place, brakes, period))
        for place, angle in zip(places.tolist(), angles.tolist())
    )


def _level(way: Way, starts: np.ndarray, ends: np.ndarray, up: Vector3) -> np.ndarray:
    """(N,3) directions of length 1 between points of the way, as seen from above."""
    chords = _at(way, ends) - _at(way, starts)
    chords -= (chords @ np.array(up))[:, None] * np.array(up)
    return chords / np.maximum(np.linalg.norm(chords, axis=1, keepdims=True), 1e-9)


def _at(way: Way, lengths: np.ndarray) -> np.ndarray:
    columns = (np.interp(lengths, way.travelled, way.points[:, axis]) for axis in range(3))
    return np.stack(list(columns), axis=1)
