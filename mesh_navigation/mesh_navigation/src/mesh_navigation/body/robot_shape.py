"""The ground that a robot covers, from its parameters, with a distance to keep around it."""

import math
from typing import Any, List, Mapping, Optional, Sized, Tuple

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter, checked_values
from mesh_map.layers.robot_outline import listed_corners
from mesh_map.map.footprint import Footprint

# A pose farther than this from the surface is not on the map (m): base frames lie some decimeters
# above the ground, and the next storey is farther away.
MAX_DISTANCE = 0.4

SHAPE_PARAMETERS = (
    Parameter("footprint", (), description="corners [[x, y], ...] in the robot's frame (m)"),
    Parameter("robot_radius", 0.0, 0.0, 100.0, "of a round robot (m), 0: a point"),
)
_CORNERS = 12  # of a circle


class RobotShape:
    """A convex polygon, a circle, or a point."""

    def __init__(self, corners: Any = (), radius: float = 0.0) -> None:
        """
        Args:
            corners: (N,2) m, of which the convex hull counts; none: a circle.
            radius: of that (m); 0: a point.

        Raises:
            MeshMapError: corners that are no numbers, or have no area.
        """
        self._radius = radius
        is_empty = isinstance(corners, Sized) and not len(corners)
        self._corners = np.zeros((0, 2)) if is_empty else _hull(_points(corners))

    @classmethod
    def of_parameters(cls, given: Mapping[str, Any]) -> "RobotShape":
        """The shape that parameters say; a footprint may be text, as for costmap_2d.

        Raises:
            MeshMapError: one that cannot be used: no robot is taken for smaller than it is.
        """
        values, warnings = checked_values(
            SHAPE_PARAMETERS,
            {**given, "footprint": listed_corners(given.get("footprint", ()))},
        )
        if warnings:
            raise MeshMapError(f"robot_radius is {given['robot_radius']}, not from 0 to 100 m")
        try:
            return cls(values["footprint"], float(values["robot_radius"]))  # type: ignore[arg-type]
        except MeshMapError as error:
            raise MeshMapError(f"footprint: {error}") from error

    @property
    def inscribed_radius(self) -> float:
        """Of the largest circle around its origin that it covers (m)."""
        if not len(self._corners):
            return self._radius
        return max(float(self.depths(np.zeros((1, 2)))[0]), 0.0)

    @property
    def circumscribed_radius(self) -> float:
        """Of the smallest circle around its origin that covers it (m)."""
        radius = self._radius if self.is_round else 0.0
        return float(np.linalg.norm(self._corners, axis=1).max(initial=radius))

    def depths(self, points: np.ndarray) -> np.ndarray:
        """(...) m: how far inside points (..., 2) of the robot's frame are; below 0 outside.

        Beside a corner, a point counts as no farther away than from the nearer side's line.
        """
        if not len(self._corners):
            return self._radius - np.hypot(points[..., 0], points[..., 1])
        sides = np.roll(self._corners, -1, 0) - self._corners
        inwards = np.stack([-sides[:, 1], sides[:, 0]]) / np.linalg.norm(sides, axis=1)
        offsets = np.einsum("ij,ji->i", self._corners, inwards)
        return (points @ inwards - offsets).min(axis=-1)

    @property
    def is_round(self) -> bool:
        """Whether it is a circle or a point."""
        return not len(self._corners)

    @property
    def is_point(self) -> bool:
        """Whether it covers nothing."""
        return self.is_round and self._radius == 0.0

    def footprint(self, distance: float) -> Optional[Footprint]:
        """What is covered with a distance around it (m, >= 0), a little more where it is round;
        None for a point."""
        heights = {"below": MAX_DISTANCE, "above": MAX_DISTANCE}
        if not len(self._corners):
            radius = self._radius + distance
            return Footprint.circle(radius, _CORNERS, **heights) if radius > 0.0 else None
        if distance == 0.0:
            return Footprint(self._corners, **heights)
        round_it = Footprint.circle(distance, _CORNERS).polygon
        return Footprint(_hull((self._corners[:, None] + round_it).reshape(-1, 2)), **heights)


def _points(corners: Any) -> np.ndarray:
    try:
        points = np.array(corners, dtype=np.float64)
    except (TypeError, ValueError):
        points = np.zeros(0)
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        text = f"{corners!r} are no corners".replace("\n", " ")
        raise MeshMapError(text, "[[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]] are")
    return points


def _hull(points: np.ndarray) -> np.ndarray:
    """Corners of the convex hull, counter-clockwise (A. Andrew: Another Efficient Algorithm for
    Convex Hulls in Two Dimensions, 1979)."""
    ordered = sorted(set(map(tuple, points.tolist())))
    size = max(math.dist(ordered[0], ordered[-1]), 1e-9)
    chains: List[List[Tuple[float, float]]] = []
    for side in (ordered, ordered[::-1]):
        chain: List[Tuple[float, float]] = []
        for point in side:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 1e-9 * size * size:
                chain.pop()
            chain.append(point)
        chains.append(chain[:-1])
    hull = chains[0] + chains[1]
    if len(hull) < 3:
        raise MeshMapError(f"the {len(points)} corners have no area between them")
    return np.array(hull)


def _turn(a: Tuple[float, float], b: Tuple[float, float], c: Tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
