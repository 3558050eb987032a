"""What a robot covers of the ground it stands on, for the layer of obstacles."""

from typing import Any

import numpy as np
import yaml

from mesh_map.base.errors import MeshMapError

LEVEL = 0.5  # meters above and below the robot's frame, within which ground is its own


class RobotOutline:
    """A polygon, or a circle, in the frame of a robot."""

    def __init__(self, corners: Any = (), radius: float = 0.0) -> None:
        """
        Args:
            corners: (N, 2) meters, in their order; none: the circle.
            radius: meters; 0: the robot covers nothing.
        Raises:
            MeshMapError: no three corners of finite numbers.
        """
        try:
            self._corners = np.array(corners, np.float64).reshape(len(corners), 2)
        except (TypeError, ValueError) as error:
            raise MeshMapError("footprint is %r, no corners [[x, y], ...]" % (corners,)) from error
        if 0 < len(corners) < 3 or not np.isfinite(self._corners).all():
            raise MeshMapError("footprint needs 3 or more finite corners, not %r" % (corners,))
        self._radius = radius

    def __bool__(self) -> bool:
        return bool(len(self._corners)) or self._radius > 0.0

    def covers(self, rotation: np.ndarray, translation: np.ndarray, points: np.ndarray) -> Any:
        """Which of (N, 3) points are above or below it, (N,) bool.

        Args:
            rotation, translation: (3, 3) and (3,), from the robot's frame to that of the points.
        """
        x, y = ((points - translation) @ rotation)[:, :2].T
        if not len(self._corners):
            return x * x + y * y < self._radius**2
        inside = np.zeros(len(points), np.bool_)
        for (ax, ay), (bx, by) in zip(self._corners, np.roll(self._corners, -1, axis=0)):
            if ay != by:  # each side that a ray along x meets turns inside out
                inside ^= ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
        return inside


def listed_corners(footprint: Any) -> Any:
    """A footprint as a list where it is text, as for costmap_2d; empty text is none.

    Raises:
        MeshMapError: text that is no list.
    """
    if not isinstance(footprint, str):
        return footprint
    try:
        found = yaml.safe_load(footprint or "[]")
    except yaml.YAMLError:
        found = None
    if not isinstance(found, list):
        raise MeshMapError("footprint is %r, no corners [[x, y], ...]" % footprint)
    return found


def on_level(rotation: np.ndarray, translation: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Which of N faces with (N, 3, 3) corners are on the robot's level, not on another floor."""
    heights = (corners - translation) @ rotation[:, 2]
    return (heights.min(axis=1) <= LEVEL) & (heights.max(axis=1) >= -LEVEL)
