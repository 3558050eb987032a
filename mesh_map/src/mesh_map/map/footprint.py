"""What is under the footprint of a robot."""

import math
from typing import Any, NamedTuple, Sequence

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.base.query_arguments import float_array, number


class Footprint:
    """The ground that a robot covers: a convex polygon in its frame (x ahead, y left, z up).

    With how far below and above it the ground is looked for.

    Attributes:
        polygon: (N, 2) float64, counter-clockwise.
        below, above: meters from the origin of the robot along its z axis.
    """

    def __init__(self, polygon: Any, below: float = 0.3, above: float = 0.3) -> None:
        """Checks the footprint.

        Args:
            polygon: (N, 2) meters, N >= 3, in either direction.
            below, above: meters, >= 0.
        Raises:
            MeshMapError: the polygon is not convex, has no area or corners twice, or a number is
                not finite or is negative.
        """
        try:
            corners = float_array(polygon, "the footprint", (None, 2))
            self.below = number(below, "below")
            self.above = number(above, "above")
        except ValueError as error:
            raise MeshMapError(str(error)) from error
        for name, height in (("below", self.below), ("above", self.above)):
            if not (height >= 0.0 and math.isfinite(height)):
                raise MeshMapError("%s has to be 0 m or more, not %g" % (name, height))
        self.polygon = _checked_polygon(corners)
        self.polygon.flags.writeable = False

    @classmethod
    def circle(cls, radius: float, corners: int = 16, **heights: float) -> "Footprint":
        """A regular polygon around a circle. As Footprint(): below, above."""
        usable = isinstance(radius, (int, float, np.number)) and 0.0 < radius < math.inf
        if not usable or not isinstance(corners, (int, np.integer)) or corners < 3:
            raise MeshMapError(
                "there is no circle of radius %r m with %r corners" % (radius, corners),
                "a radius above 0 and at least 3 corners are needed",
            )
        angles = (np.arange(corners) + 0.5) * (2.0 * math.pi / corners)
        outer = radius / math.cos(math.pi / corners)
        return cls(outer * np.stack([np.cos(angles), np.sin(angles)], 1), **heights)


class FootprintCost(NamedTuple):
    """What is under a footprint: of all faces that touch it, within its heights.

    maximum: the largest cost anywhere under it, over the faces whose costs are all known and not
        lethal; 0 without such.
    lethal: whether a face has a lethal corner.
    unknown: whether a face has a corner of unknown cost.
    ground: share of the footprint that has ground below or above it, 0 to 1, by a grid of points.
    face_count: faces; 0 off the map.
    """

    maximum: float
    lethal: bool
    unknown: bool
    ground: float
    face_count: int

    @property
    def cost(self) -> float:
        """One number: +inf if lethal, else NaN if unknown or off the map, else the maximum."""
        if self.lethal:
            return math.inf
        return math.nan if self.unknown or not self.face_count else self.maximum


class FootprintCosts(NamedTuple):
    """What is under a footprint at N poses, as arrays; see FootprintCost.

    maxima: (N,) float32.
    lethal, unknown: (N,) bool.
    ground: (N,) float64.
    face_counts: (N,) uint32.
    """

    maxima: np.ndarray
    lethal: np.ndarray
    unknown: np.ndarray
    ground: np.ndarray
    face_counts: np.ndarray

    def cost(self, index: int) -> FootprintCost:
        """One of them."""
        return FootprintCost(
            float(self.maxima[index]),
            bool(self.lethal[index]),
            bool(self.unknown[index]),
            float(self.ground[index]),
            int(self.face_counts[index]),
        )

    def costs(self) -> np.ndarray:
        """(N,) float32: FootprintCost.cost of each."""
        known = np.where(self.unknown | (self.face_counts == 0), np.float32(np.nan), self.maxima)
        return np.where(self.lethal, np.float32(np.inf), known)


class FootprintVertices(NamedTuple):
    """The vertices under a footprint at N poses, in one row.

    offsets: (N + 1,) uint64, where those of a pose begin, and the end of all.
    vertices: uint32, ascending for each pose.
    """

    offsets: np.ndarray
    vertices: np.ndarray

    def of(self, index: int) -> np.ndarray:
        """Those of one pose."""
        return self.vertices[self.offsets[index] : self.offsets[index + 1]]


def pose_rows(poses: Any) -> np.ndarray:
    """(N, 3, 4) float64 of matrices.

    Args:
        poses: (N, 4, 4), from the frame of the robot to that of the mesh; such as
            SurfaceWalk.matrix(). One that is not finite is nowhere.
    Raises:
        ValueError: another shape, or a matrix that does more than turn and shift (the first is
            named).
    """
    matrices = float_array(poses, "poses", (None, 4, 4))
    finite = np.isfinite(matrices).all((1, 2))
    turns = np.where(finite[:, None, None], matrices, np.eye(4))[:, :3, :3]
    off = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max((1, 2), initial=0.0)
    wrong = np.flatnonzero((off > 1e-6) | (np.linalg.det(turns) < 0.0))
    if len(wrong):
        raise ValueError(
            "pose %d does more than turn and shift: its axes are no right-handed unit vectors at"
            " right angles (off by %g; %d such in all)" % (wrong[0], off[wrong[0]], len(wrong))
        )
    return np.ascontiguousarray(matrices[:, :3])


def _checked_polygon(corners: Sequence[Any]) -> np.ndarray:
    points = np.array(corners)
    if len(points) < 3 or not np.isfinite(points).all():
        raise MeshMapError("the footprint needs 3 corners or more, of finite numbers")
    sides = np.roll(points, -1, 0) - points
    after = np.roll(sides, -1, 0)
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    angles = np.arctan2(turns, np.sum(sides * after, 1))
    same = np.flatnonzero(~sides.any(1))
    if len(same):
        raise MeshMapError("corner %d of the footprint and the one after it are the same" % same[0])
    if angles.sum() < 0.0:
        points, turns = points[::-1].copy(), -turns
    wrong = np.flatnonzero(turns < 0.0)
    if len(wrong) or abs(abs(angles.sum()) - 2.0 * math.pi) > 1e-3:
        where = " at corner %d" % ((wrong[0] + 1) % len(turns)) if len(wrong) else ""
        raise MeshMapError(
            "the footprint is not convex%s" % where,
            "its convex hull covers all of it: scipy.spatial.ConvexHull",
        )
    return points
