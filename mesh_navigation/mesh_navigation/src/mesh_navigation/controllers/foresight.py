"""Where an arc would lead the robot before it could stop."""

import math
from typing import Optional

import numpy as np

from mesh_map.geometry.walk import SurfaceWalker, WalkEnd

from mesh_navigation.controllers.ground import Ground
from mesh_navigation.controllers.standing import MAX_STEPS, Standing
from mesh_navigation.controllers.vector3 import Vector3, cross, vector3

_STEP = 0.1  # m, of the straight pieces that stand for an arc
_MOST_STEPS = 8


def free_arc(
    walker: SurfaceWalker, ground: Ground, standing: Standing, curvature: float, length: float
) -> Optional[float]:
    """How far an arc leads over free ground (m) if not all of it does; None: all of it is free.

    Args:
        walker: over the surface.
        ground: where it is blocked.
        standing: where the arc begins, along the heading.
        curvature: rad/m, to the left.
        length: m.
    """
    steps = 1 if curvature == 0.0 else min(max(math.ceil(length / _STEP), 2), _MOST_STEPS)
    step = length / steps
    place, heading = standing, standing.heading
    points, faces, walked, ended = [], [], 0.0, False
    for _ in range(steps):
        heading = _turned(heading, vector3(place.normal), curvature * step / 2)
        walk = walker.walk(
            start=place, length=step, direction=heading, max_steps=MAX_STEPS, path=True
        )
        if len(walk.path.faces):
            points.append(walk.path.points[:-1])
            faces.append(walk.path.faces)
        walked += walk.length
        place = walk
        heading = _turned(vector3(walk.direction), vector3(walk.normal), curvature * step / 2)
        if walk.end != WalkEnd.ARRIVED:
            ended = True
            break
    points.append(place.position[None])
    if faces:
        blocked = ground.first_blocked(np.concatenate(points), np.concatenate(faces))
        if blocked is not None:
            return blocked
    return walked if ended else None


def _turned(heading: Vector3, normal: Vector3, angle: float) -> Vector3:
    left = cross(normal, heading)
    c, s = math.cos(angle), math.sin(angle)
    return (
        c * heading[0] + s * left[0],
        c * heading[1] + s * left[1],
        c * heading[2] + s * left[2],
    )
