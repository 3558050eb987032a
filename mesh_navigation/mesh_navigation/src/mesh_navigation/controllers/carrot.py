"""The point ahead at which the robot looks: the carrot of pure pursuit."""

from typing import NamedTuple, Optional

import numpy as np

from mesh_navigation.controller import ControlFailure
from mesh_navigation.controllers.sight import Sight, View
from mesh_navigation.controllers.standing import Standing
from mesh_navigation.controllers.vector3 import along_plane, dot, signed_angle, vector3
from mesh_navigation.controllers.way import Way
from mesh_navigation.outcomes import ExePathOutcome
from mesh_navigation.pose import vector_text

_HALVINGS = 8
_WIDE_HALVINGS = 4  # with room on both sides


class Carrot(NamedTuple):
    """Where to look."""

    distance: float
    """m, straight over the surface."""
    angle: float
    """From the heading to it (rad), to the left positive."""
    is_near: bool
    """Whether it had to be taken nearer than asked for."""


def find_carrot(
    sight: Sight, standing: Standing, way: Way, reach: float, clearance: float
) -> Carrot:
    """The farthest point of the way to which the robot can drive straight on: the length along the
    way is halved until that is so.

    First with room on both sides of the line, beside the way where it is too near to a border or to
    blocked ground; where there is not as much room, without; then on the way itself.

    Args:
        sight: from where the robot stands.
        standing: that.
        way: ahead of it.
        reach: m, along the way.
        clearance: room that is looked for on both sides (m).

    Raises:
        ControlFailure: BLOCKED_PATH, no point of the way can be seen.
    """
    longest = min(reach, way.length)
    view: Optional[View] = None
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
    raise ControlFailure(
        ExePathOutcome.BLOCKED_PATH,
        f"the way from the robot at {vector_text(standing.position)} to "
        f"{vector_text(way.points[0])} {view.reason} after {view.blocked:.2f} m",
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
