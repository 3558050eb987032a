"""The point ahead at which the robot looks: the carrot of pure pursuit."""

import math
from typing import NamedTuple, Optional, Sequence

import numpy as np

from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import vector_text
from mesh_navigation.controllers.sight import Sight
from mesh_navigation.controllers.standing import Standing
from mesh_navigation.controllers.vector3 import along_plane, dot, signed_angle, vector3
from mesh_navigation.controllers.way import Way
from mesh_navigation.plugins.controller import ControlFailure

_HALVINGS = 8
_WIDE_HALVINGS = 4  # with room on both sides
_STEP = 0.05  # m along a way that begins at the robot, where sharp edges hide all of it
_HERE = 1e-3  # m


class Carrot(NamedTuple):
    """Where to look."""

    distance: float
    """m, straight over the surface."""
    angle: float
    """From the heading to it (rad), to the left positive."""
    is_near: bool
    """Whether it had to be taken nearer than asked for."""


def find_carrot(sight: Sight, ways: Sequence[Way], reach: float, clearance: float) -> Carrot:
    """The farthest point of the way to which the robot can drive straight on: the length along the
    way is halved until that is so.

    First with room on both sides of the line, beside the way where it is too near to a border or to
    blocked ground; where there is not as much room, without; then on the way itself, and in the
    end just along a way that begins here: the caller has seen that it is free.

    Args:
        sight: from where the robot stands.
        ways: ahead of it; the next one is for where nothing of those before can be seen.
        reach: m, along the way.
        clearance: room that is looked for on both sides (m).

    Raises:
        ControlFailure: BLOCKED_PATH, no point of the way can be seen.
    """
    standing = sight.standing
    for way in ways:
        longest = min(reach, way.length)
        for halvings, room, wide in (
            (_WIDE_HALVINGS, clearance, True),
            (_HALVINGS, clearance, False),
            (_HALVINGS, 0.0, False),
        ):
            for halved in range(halvings):
                corridor = sight.corridor(way, longest / 2**halved, room)
                view = sight.look(corridor.middle)
                if view.blocked is None and not (wide and _is_narrow(sight, corridor.sides)):
                    angle = _angle_to(standing, corridor.middle)
                    return Carrot(view.distance, angle, halved > 0)
    start = ways[0].points[0]
    if math.dist(start, standing.position) < _HERE and ways[0].length > 0.0:
        step = min(_STEP, ways[0].length)
        return Carrot(step, _angle_to(standing, ways[0].at(step)), True)
    view = sight.look(start)
    reason, length = view.reason or "is blocked", view.blocked or 0.0
    raise ControlFailure(
        ExePathOutcome.BLOCKED_PATH,
        f"the way from the robot at {vector_text(standing.position)} to {vector_text(start)} and "
        f"on {reason} after {length:.2f} m",
    )


def _is_narrow(sight: Sight, sides: list) -> bool:
    return any(sight.look(side).blocked is not None for side in sides)


def _angle_to(standing: Standing, point: np.ndarray) -> float:
    direction = standing.direction_to(vector3(point))
    if direction is None:
        return 0.0
    return signed_angle(standing.heading, direction, standing.normal)


def heading_error(standing: Standing, direction: np.ndarray) -> Optional[float]:
    """From the heading to a direction, as far as that is along the surface (rad, to the left);
    None if it is not."""
    flat = along_plane(vector3(direction), standing.normal)
    if dot(flat, flat) < 1e-6:
        return None
    return signed_angle(standing.heading, flat, standing.normal)
