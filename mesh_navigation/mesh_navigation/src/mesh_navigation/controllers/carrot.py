"""The point ahead at which the robot looks: the carrot of pure pursuit."""

import math
from typing import NamedTuple, Optional, Sequence

import numpy as np

from mesh_navigation.base.outcomes import ExePathOutcome
from mesh_navigation.base.pose import vector_text
from mesh_navigation.controllers.sight import Sight
from mesh_navigation.controllers.surface_pose import SurfacePose
from mesh_navigation.controllers.vector3 import along_plane, dot, signed_angle, vector3
from mesh_navigation.controllers.local_path import LocalPath
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


def find_carrot(sight: Sight, paths: Sequence[LocalPath], reach: float, clearance: float) -> Carrot:
    """The farthest point of the way to which the robot can drive straight on: the length along the
    way is halved until that is so.

    First with room on both sides of the line, beside the way where it is too near to a border or to
    blocked ground; where there is not as much room, without; then on the way itself, and in the
    end just along a way that begins here: the caller has seen that it is free.

    Args:
        sight: from where the robot stands.
        paths: ahead of it; the next one is for where nothing of those before can be seen.
        reach: m, along the way.
        clearance: room that is looked for on both sides (m).

    Raises:
        ControlFailure: BLOCKED_PATH, no point of the way can be seen.
    """
    surface_pose = sight.surface_pose
    for way in paths:
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
                    angle = _angle_to(surface_pose, corridor.middle)
                    return Carrot(view.distance, angle, halved > 0)
    start = paths[0].points[0]
    if math.dist(start, surface_pose.position) < _HERE and paths[0].length > 0.0:
        step = min(_STEP, paths[0].length)
        return Carrot(step, _angle_to(surface_pose, paths[0].at(step)), True)
    view = sight.look(start)
    reason, length = view.reason or "is blocked", view.blocked or 0.0
    raise ControlFailure(
        ExePathOutcome.BLOCKED_PATH,
        f"the way from the robot at {vector_text(surface_pose.position)} to {vector_text(start)} "
        f"and on {reason} after {length:.2f} m",
    )


def _is_narrow(sight: Sight, sides: list) -> bool:
    return any(sight.look(side).blocked is not None for side in sides)


def _angle_to(surface_pose: SurfacePose, point: np.ndarray) -> float:
    direction = surface_pose.direction_to(vector3(point))
    if direction is None:
        return 0.0
    return signed_angle(surface_pose.heading, direction, surface_pose.normal)


def heading_error(surface_pose: SurfacePose, direction: np.ndarray) -> Optional[float]:
    """From the heading to a direction, as far as that is along the surface (rad, to the left);
    None if it is not."""
    flat = along_plane(vector3(direction), surface_pose.normal)
    if dot(flat, flat) < 1e-6:
        return None
    return signed_angle(surface_pose.heading, flat, surface_pose.normal)
