"""Walks over a surface, and where they end."""

import enum
import math
from typing import Any, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices

from mesh_map import _kernels
from mesh_map.base.cancel import CancelFlag, kernel_flag
from mesh_map.base.query_arguments import (
    float_array,
    mask_array,
    number,
    per_item,
    points_array,
    vector,
    whole_number,
)
from mesh_map.geometry.topology import Topology
from mesh_map.spatial.hits import NO_FACE

MAX_STEPS = 1_000_000  # faces of one walk
_NOWHERE = np.zeros(3)


class WalkEnd(enum.IntEnum):
    """Why a walk ended.

    ARRIVED: all of the length was walked, or a line came to its target.
    BORDER: the surface ends there.
    BLOCKED: the next face is not in the mask.
    STEPS: there were more faces than max_steps.
    NOWHERE: no walk at all: no face, one without area, barycentric coordinates of no point in it, a
        number that is not finite, or no direction along the face.
    LOOP: a line came to where it has been: its cut does not lead to the target, as round a peak
        that leans over. Its length has no meaning.
    """

    ARRIVED = 0
    BORDER = 1
    BLOCKED = 2
    STEPS = 3
    NOWHERE = 4
    LOOP = 5


class WalkPath(NamedTuple):
    """The way of a walk.

    points: (N + 1, 3) float64, meters: the start, each crossing of an edge, and the end.
    faces: (N,) uint32; face i has the points i and i + 1.
    """

    points: np.ndarray
    faces: np.ndarray


class SurfaceWalk(NamedTuple):
    """The end of a walk: a pose on the surface from which to walk on.

    face: index; that of the start where there was no walk.
    position: (3,) float64, meters.
    barycentric: (3,) float64, weights of the corners of the face.
    direction: (3,) float64 of length 1 along the face: where the walker looks. A line of no length
        looks nowhere (zeros).
    normal: (3,) float64 of length 1, of the face, to the side of the surface on which he is.
    length: meters that were walked, >= 0, in either direction.
    end: why it ended.
    path: the way, if it was asked for.
    """

    face: int
    position: np.ndarray
    barycentric: np.ndarray
    direction: np.ndarray
    normal: np.ndarray
    length: float
    end: WalkEnd
    path: Optional[WalkPath] = None

    def turned(self, angle: float) -> "SurfaceWalk":
        """The same pose looking this angle (radians) farther to the left."""
        # Number by number: robots turn in every step, and np.cross takes ten times as long.
        (a, b, c), (x, y, z) = self.normal.tolist(), self.direction.tolist()
        left = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
        return self._replace(direction=math.cos(angle) * self.direction + math.sin(angle) * left)

    def matrix(self) -> np.ndarray:
        """(4, 4), from the frame of the walker (x ahead, y left, z up) to that of the mesh."""
        result = np.eye(4)
        left = np.cross(self.normal, self.direction)
        result[:3] = np.stack([self.direction, left, self.normal, self.position], 1)
        return result


class SurfaceWalks(NamedTuple):
    """The ends of N walks as arrays; see SurfaceWalk.

    faces: (N,) uint32.
    positions, barycentric, directions, normals: (N, 3) float64.
    lengths: (N,) float64.
    ends: (N,) uint8 of WalkEnd.
    paths: one for each, if they were asked for.
    """

    faces: np.ndarray
    positions: np.ndarray
    barycentric: np.ndarray
    directions: np.ndarray
    normals: np.ndarray
    lengths: np.ndarray
    ends: np.ndarray
    paths: Optional[Sequence[WalkPath]] = None

    def walk(self, index: int) -> SurfaceWalk:
        """One of them."""
        return SurfaceWalk(
            int(self.faces[index]),
            self.positions[index],
            self.barycentric[index],
            self.directions[index],
            self.normals[index],
            float(self.lengths[index]),
            WalkEnd(int(self.ends[index])),
            None if self.paths is None else self.paths[index],
        )


def walk_arrays(vertices: Any, faces: Any, topology: Topology) -> Tuple[np.ndarray, ...]:
    """What kernels that go from face to face keep of a mesh: vertices, faces, what is next to what.

    Raises:
        ValueError: wrong shapes or numbers.
    """
    return (
        as_vertices(vertices),
        as_faces(faces),
        topology.face_edges,
        topology.face_flags,
        topology.edge_face_offsets,
        topology.edge_faces,
        topology.vertex_face_offsets,
        topology.vertex_faces,
    )


class SurfaceWalker:
    """Walks over the faces of a mesh: what moves a robot on it, or looks ahead.

    walk() goes straight on: the straightest geodesic (Polthier and Schmies, Straightest geodesics
    on polyhedral surfaces, 1998), straight where the faces that it crosses are
    unfolded into a plane, with as much angle on the left as on the right of a vertex. At a vertex
    of a border, and where only corners touch, it goes on in the face that contains its direction as
    seen along the normal of the face in which it is. Faces may be flipped, duplicate, or without
    area. Of more than two faces at an edge, the walk goes on in the one that bends least. line()
    goes to a target, straight as seen from above; from a vertex, into the face there that contains
    the way.

    A walk can be walked on with from where it ended, as if there had been no stop:

        walk = walker.walk(start=point, direction=(1, 0, 0), length=0.5)
        walk = walker.walk(start=walk.turned(0.1), length=-0.2)  # turns left, backs up

    The same arguments give the same walk. Any thread may ask at any time; the GIL is released
    meanwhile. An answer takes less than a microsecond for each face.

    Arguments of all methods:
        start: a SurfacePoint or SurfaceWalk (of batches: SurfacePoints or SurfaceWalks), or
            anything that has its face(s) and barycentric coordinates.
        up: (3,) any direction from the surface to the side on which the walker is, which tells left
            from right; None for the normal of the start if it has one, else for that of its face.
        mask: (F,) bool, the faces that may be entered (the first one may be left in any case); None
            for all. It does not bend a walk, but through corners of a border where faces overlap.
        max_steps: faces of a walk.
        path: True to be told the way.
    """

    def __init__(self, *, vertices: Any, faces: Any, topology: Topology) -> None:
        """Args:
            vertices: (V, 3) meters.
            faces: (F, 3) vertex indices.
            topology: of these faces.
        Raises:
            ValueError: a face that refers to no vertex, or the topology of another mesh.
        """
        arrays = walk_arrays(vertices, faces, topology)
        self.face_count = len(arrays[1])
        self.kernel = _kernels._Surface(*arrays)

    def walk(
        self,
        *,
        start: Any,
        length: float,
        direction: Optional[Any] = None,
        up: Optional[Any] = None,
        mask: Optional[Any] = None,
        max_steps: int = MAX_STEPS,
        path: bool = False,
    ) -> SurfaceWalk:
        """Straight on.

        Args:
            start, up, mask, max_steps, path: see the class.
            length: meters; below 0 to walk backwards (looking ahead); infinite to the border.
            direction: (3,) where to; what of it is along the face counts. None for where the start,
                a SurfaceWalk, looks.
        Raises:
            ValueError: another shape, or no direction.
        """
        way = _direction(start, "direction") if direction is None else direction
        meters = number(length, "length")
        return self._run_one(start, way, up, meters, None, mask, max_steps, path)

    def walk_batch(
        self,
        *,
        starts: Any,
        lengths: Any,
        directions: Optional[Any] = None,
        ups: Optional[Any] = None,
        mask: Optional[Any] = None,
        max_steps: int = MAX_STEPS,
        paths: bool = False,
        cancel: Optional[CancelFlag] = None,
    ) -> SurfaceWalks:
        """walk() from each of N starts.

        Args:
            starts, mask, max_steps, paths: see the class.
            lengths: (N,), or a number for all.
            directions, ups: (N, 3), or (3,) for all; or None as in walk().
            cancel: CancelFlag that ends the batch with Canceled.
        Raises:
            ValueError: other shapes, or no directions.
            Canceled: by `cancel`.
        """
        ways = _direction(starts, "directions") if directions is None else directions
        count = len(starts.faces)
        meters = np.asarray(lengths)
        if meters.ndim == 0:
            meters = np.full(count, meters)
        meters = float_array(meters, "lengths", (count,))
        return self._run(starts, ways, ups, meters, None, mask, max_steps, paths, cancel)

    def line(
        self,
        *,
        start: Any,
        target: Any,
        up: Optional[Any] = None,
        mask: Optional[Any] = None,
        max_steps: int = MAX_STEPS,
        path: bool = False,
    ) -> SurfaceWalk:
        """To a target, straight as seen along `up`: the cut of the surface with the plane through
        start, target and `up`. It ends (ARRIVED) where the way is done as seen along `up`: at the
        target, or on another storey above or below it, which the position tells.

        Args:
            start, up, mask, max_steps, path: see the class.
            target: (3,) meters.
        Raises:
            ValueError: another shape.
        """
        goal = vector(target, "target")
        return self._run_one(start, _NOWHERE, up, 0.0, goal, mask, max_steps, path)

    def line_batch(
        self,
        *,
        starts: Any,
        targets: Any,
        ups: Optional[Any] = None,
        mask: Optional[Any] = None,
        max_steps: int = MAX_STEPS,
        paths: bool = False,
        cancel: Optional[CancelFlag] = None,
    ) -> SurfaceWalks:
        """line() from each of N starts.

        Args:
            starts, mask, max_steps, paths: see the class.
            targets: (N, 3), or (3,) for all.
            ups: (N, 3), or (3,) for all; or None as in line().
            cancel: CancelFlag that ends the batch with Canceled.
        Raises:
            ValueError: other shapes.
            Canceled: by `cancel`.
        """
        goals = _rows(targets, "targets", len(starts.faces))
        return self._run(starts, _NOWHERE, ups, None, goals, mask, max_steps, paths, cancel)

    def _run_one(
        self,
        start: Any,
        direction: Any,
        up: Optional[Any],
        length: float,
        target: Optional[np.ndarray],
        mask: Optional[Any],
        max_steps: int,
        path: bool,
    ) -> SurfaceWalk:
        face = int(start.face)
        *found, end, way = self.kernel._walk_one(
            face if 0 <= face < NO_FACE else NO_FACE,
            start.barycentric,
            direction,
            getattr(start, "normal", _NOWHERE) if up is None else up,
            length,
            target,
            mask_array(mask, self.face_count),
            whole_number(max_steps, "max_steps"),
            path,
        )
        return SurfaceWalk(*found, WalkEnd(end), None if way is None else WalkPath(*way))

    def _run(
        self,
        starts: Any,
        directions: Any,
        ups: Optional[Any],
        lengths: Optional[np.ndarray],
        targets: Optional[np.ndarray],
        mask: Optional[Any],
        max_steps: int,
        paths: bool,
        cancel: Optional[CancelFlag] = None,
    ) -> SurfaceWalks:
        faces, weights = _starts(starts)
        if ups is None:
            ups = getattr(starts, "normals", _NOWHERE)
        found = self.kernel._walk(
            faces,
            weights,
            _rows(directions, "directions", len(faces)),
            _rows(ups, "up", len(faces)),
            lengths,
            targets,
            mask_array(mask, self.face_count),
            whole_number(max_steps, "max_steps"),
            paths,
            0,
            kernel_flag(cancel),
        )
        ways = None if found[-1] is None else [WalkPath(*way) for way in found[-1]]
        return SurfaceWalks(*found[:-1], ways)


def _direction(start: Any, name: str) -> Any:
    if not hasattr(start, name):
        raise ValueError("%s is needed: the start does not look anywhere" % name)
    return getattr(start, name)


def _starts(starts: Any) -> Tuple[np.ndarray, np.ndarray]:
    """Faces and barycentric coordinates; such that are no face become NO_FACE."""
    faces = np.asarray(starts.faces)
    if faces.ndim != 1 or faces.dtype.kind not in "iu":
        raise ValueError("the faces of starts have to be a row of whole numbers")
    faces = np.where((faces < 0) | (faces > NO_FACE), NO_FACE, faces).astype(np.uint32)
    return faces, float_array(starts.barycentric, "barycentric", (len(faces), 3))


def _rows(values: Any, name: str, count: int) -> np.ndarray:
    """(N, 3), also of one row for all."""
    if np.asarray(values).ndim == 2 and len(values) != 1:
        return float_array(values, name, (count, 3))
    rows = per_item(values, name, count) if count else points_array([], name)
    return np.ascontiguousarray(np.broadcast_to(rows, (count, 3)))
