"""Obstacles that a sensor sees: on which faces of a mesh they stand, and since when."""

from typing import Any, NamedTuple

import numpy as np

from mesh_map.base.array_checks import read_only
from mesh_map.spatial.hits import NO_FACE, RayHits
from mesh_map.spatial.spatial_index import SpatialIndex

CELL = 0.1  # meters
MOST_MARKS = 2000000  # about 120 MB
_CELL_BITS = 10


class CloudPoints(NamedTuple):
    """What the N points of a cloud are.

    finite: (N,) bool; all others are False where this is.
    in_range: (N,) bool.
    ground: (N,) bool, in range, and on the surface.
    faces: (N,) uint32, the face that an obstacle stands on; NO_FACE for points that are none: out
        of range, ground, with no surface below, or too high above it.
    """

    finite: np.ndarray
    in_range: np.ndarray
    ground: np.ndarray
    faces: np.ndarray


def find_obstacles(
    index: SpatialIndex,
    points: np.ndarray,
    origin: np.ndarray,
    down: Any,
    *,
    nearest: float = 0.0,
    farthest: float = np.inf,
    lowest: float = 0.0,
    highest: float = np.inf,
) -> CloudPoints:
    """Casts each point of a cloud down onto the mesh.

    Args:
        index: of the mesh.
        points: (N, 3) float64, in the frame of the mesh; those that are not finite do not count.
        origin: (3,), of the sensor.
        down: (3,), the direction in which surface is looked for.
        nearest, farthest: meters from the sensor, between which a point is an obstacle.
        lowest, highest: the same above the surface. Points below `lowest` are ground, also those
            that lie up to as much below the surface. Where it is negative, there is no ground, and
            points stand on a surface that they lie up to so much below, unless on one below them.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        offsets = points - origin
        distances = np.sqrt(np.einsum("ij,ij->i", offsets, offsets))
        finite = np.isfinite(distances)
        in_range = finite & (distances >= nearest) & (distances <= farthest)
    asked = np.flatnonzero(in_range)
    unit = np.asarray(down, np.float64) / np.linalg.norm(down)
    raised = max(lowest, 0.0)

    def met(starts: np.ndarray, direction: np.ndarray, reach: float) -> RayHits:
        directions = np.repeat(direction[None], len(starts), axis=0)
        return index.cast_batch(origins=starts, directions=directions, max_distance=reach)

    hits = met(points[asked] - raised * unit, unit, highest + raised)
    low = hits.distances < 2 * raised
    ground = np.zeros(len(points), np.bool_)
    ground[asked] = low
    faces = np.full(len(points), NO_FACE, np.uint32)
    faces[asked] = np.where(low, np.uint32(NO_FACE), hits.faces)
    if lowest < 0:
        below = asked[hits.faces == NO_FACE]
        faces[below] = met(points[below], -unit, -lowest).faces
    return CloudPoints(finite, in_range, ground, faces)


class ObstacleMarks:
    """Points of obstacles, with the face that each stands on and the time when it was last seen.

    Of the points on one face, one is kept in each cube of CELL. A face is marked as long as it has
    such a point, so one that is as large as a hall keeps its other obstacles when one goes. Of more
    than MOST_MARKS points, the oldest are forgotten.

    Attributes:
        points: (M, 3) float64, meters.
        times: (M,) float64, seconds.
        mark_faces: (M,) uint32, on which each stands.
        faces: (K,) uint32, ascending: those that are marked.
    """

    def __init__(self, face_count: int) -> None:
        self._marked = np.zeros(face_count, np.bool_)
        self._keys = np.zeros(0, np.int64)  # ascending
        self._keep_faces(np.zeros(0, np.uint32))
        self.points = np.zeros((0, 3))
        self.times = np.zeros(0)

    def add(self, faces: np.ndarray, points: np.ndarray, time: float) -> None:
        """Adds the points of a cloud; a mark in the same cube is replaced.

        Args:
            faces: (N,) uint32; there must be such faces.
            points: (N, 3) float64, finite.
            time: seconds.
        """
        keys, first = np.unique(_keys(faces, points), return_index=True)
        if not len(keys):
            return
        place = np.searchsorted(self._keys, keys)
        known = np.append(self._keys, -1)[place] == keys
        self.points[place[known]], self.times[place[known]] = points[first[known]], time
        place, first = place[~known], first[~known]
        self._keys = np.insert(self._keys, place, keys[~known])
        self.points = np.insert(self.points, place, points[first], axis=0)
        self.times = np.insert(self.times, place, float(time))
        self._keep_faces(np.insert(self.mark_faces, place, faces[first]))

        if len(self.times) > MOST_MARKS:
            kept = np.zeros(len(self.times), np.bool_)
            kept[np.argpartition(-self.times, MOST_MARKS)[:MOST_MARKS]] = True
            self.keep(kept)

    def keep(self, kept: np.ndarray) -> None:
        """Removes all marks but these, (M,) bool."""
        if kept.all():
            return
        self._keys, self.points, self.times = self._keys[kept], self.points[kept], self.times[kept]
        self._keep_faces(self.mark_faces[kept])

    def set_back(self, time: float) -> None:
        """No mark is from later than this: for clocks that are set back."""
        self.times = np.minimum(self.times, time)

    def postpone(self, seconds: float) -> None:
        """All marks are from so much later: for a time that does not count."""
        if seconds:
            self.times = self.times + seconds

    def _keep_faces(self, faces: np.ndarray) -> None:
        self.mark_faces = faces
        self._marked[:] = False
        self._marked[faces] = True
        self.faces = read_only(np.flatnonzero(self._marked).astype(np.uint32))


def _keys(faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(N,) int64: the face, and the cube in which the point lies.

    Cubes are numbered modulo 1024 along each axis: points on one face that are over a hundred
    meters apart may share a number, and the later one then stands for both.
    """
    cubes = np.mod(np.floor(points / CELL), 1 << _CELL_BITS).astype(np.int64)
    keys = faces.astype(np.int64)
    for axis in range(3):
        keys = keys << _CELL_BITS | cubes[:, axis]
    return keys
