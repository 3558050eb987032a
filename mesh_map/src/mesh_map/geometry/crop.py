"""Cropping: a derived mesh of the faces in a region."""

from dataclasses import dataclass
from typing import Any, Dict, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh, derived_uuid

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.submesh import checked_mesh, submesh

# Of a cropped mesh: another number here gives all of them other UUIDs.
_VERSION = 1


@dataclass(frozen=True)
class Region:
    """A part of space: a box, and in it what is above and below a polygon.

    low, high: (3,) meters, the box; infinite where it has no side.
    polygon: (N, 2) x and y of its corners, closed by itself; crossings count by the even-odd rule.
        None for no polygon.
    outside: all but this is meant.
    """

    low: np.ndarray
    high: np.ndarray
    polygon: Optional[np.ndarray] = None
    outside: bool = False

    def contains(self, points: Any) -> np.ndarray:
        """(N,) bool: which points (N, 3) are in it; what lies on a side of the box is."""
        points = np.asarray(points, np.float64)
        inside = ((points >= self.low) & (points <= self.high)).all(1)
        if self.polygon is not None:
            inside &= _in_polygon(points[:, :2], np.asarray(self.polygon, np.float64))
        return ~inside if self.outside else inside

    def parameters(self) -> Dict[str, Any]:
        """What json can write: what is not finite is a text."""
        polygon = None if self.polygon is None else np.asarray(self.polygon, float).tolist()
        ends = {"low": self.low, "high": self.high}
        values: Dict[str, Any] = {
            name: [value if np.isfinite(value) else str(value) for value in end.tolist()]
            for name, end in ends.items()
        }
        return {**values, "polygon": polygon, "outside": self.outside}


def crop(vertices: Any, faces: Any, region: Region, *, parent_uuid: str = "") -> DerivedMesh:
    """The faces whose middle is in a region, and their vertices, in their order.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        region: which are kept.
        parent_uuid: identity of the mesh; that of the result follows from it.
    Raises:
        MeshMapError: no face is in the region: where the mesh is; no mesh: what is wrong.
    """
    vertices, faces = checked_mesh(vertices, faces)
    kept = np.flatnonzero(region.contains(vertices[faces].mean(1, dtype=np.float64)))
    if not len(kept):
        low, high = vertices.min(0).tolist(), vertices.max(0).tolist()
        bounds = "the mesh is between %s and %s" % tuple(
            " ".join("%.6g" % value for value in corner) for corner in (low, high)
        )
        raise MeshMapError("no face of %d has its middle in the region" % len(faces), bounds)
    parameters = {**region.parameters(), "version": _VERSION}
    return submesh(
        vertices, faces, kept, derived_uuid(parent_uuid, "crop", parameters), parent_uuid
    )


def _in_polygon(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(N,) bool: a ray from the point along x crosses the polygon an odd number of times."""
    x, y = points.T
    inside = np.zeros(len(points), bool)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, 0)):
        crosses = (ay > y) != (by > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crosses & (x < (bx - ax) * (y - ay) / (by - ay) + ax)
    return inside
