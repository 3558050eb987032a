"""Refinement: a derived mesh with the same surface and shorter edges."""

from typing import Any, List, Optional, Tuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices
from mesh_msgs.derived_mesh import DerivedMesh, derived_uuid
from mesh_msgs.validation import check_geometry

from mesh_map.base.errors import MeshMapError

# More faces are refused: a map of so many takes some gigabytes of memory.
FACE_LIMIT = 10_000_000
# Of a refined mesh: another number here gives all of them other UUIDs.
_VERSION = 1
# No refinement has more faces than so many times least_faces() (8 A/L^2 of large faces are 3.5).
_SURELY = 4
# An edge is at least so many times as long as the steps between float32 numbers around it.
_STEPS = 16


def refine(
    vertices: Any,
    faces: Any,
    max_edge_length: float,
    *,
    parent_uuid: str = "",
    face_limit: int = FACE_LIMIT,
) -> Optional[DerivedMesh]:
    """The same surface of faces without an edge longer than max_edge_length.

    Edges are halved as long as they are longer, so whatever is done to an edge follows from the
    edge alone: all faces there, whatever their number, halve it at the same vertex, and those that
    do not share their vertices, but have them at the same places, at the same place. There are no
    T-junctions, and nothing is halved that is not too long. In a face the longest edge is cut first
    (the partition of Rivara: Algorithms for refining triangular grids suitable for adaptive and
    multigrid techniques, 1984), so that none becomes much thinner than it was. Faces that are long
    and thin are cut across only, like ladders: a face of 20 m by 1 mm has as many parts as its
    length needs.

    The parent's vertices come first, in their order. New ones lie on its edges and faces as exactly
    as float32 can tell, at weights that are multiples of powers of 1/2. Faces are in the order of
    their parents, and turned as these are. The result depends on the arguments alone.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        max_edge_length: meters, above 0.
        parent_uuid: identity of the mesh; that of the result follows from it.
        face_limit: so many faces at most.
    Returns:
        None where no edge is longer.
    Raises:
        MeshMapError: a length that is not above 0, or too short for coordinates of float32; more
            faces than the limit: how many there would be, and which length would do; no mesh: what
            is wrong, where, and how often.
    """
    findings = check_geometry(vertices, faces)
    if findings:
        raise MeshMapError("no usable mesh: %s" % (findings[0],))
    vertices, faces = as_vertices(vertices), as_faces(faces)
    length = float(max_edge_length)
    if not length > 0.0:
        raise MeshMapError("max_edge_length is %g, but it has to be above 0" % length)
    longest = float(_lengths(vertices, faces).max(initial=0.0))
    if longest <= length:
        return None
    _check_steps(vertices, length)
    parts = _Parts(vertices, faces)
    while True:
        if not parts.done_count or parts.done_count + len(parts.corners) > face_limit // 4:
            least = parts.done_count + least_faces(parts.vertices, parts.corners, length)
            if least > face_limit:
                raise _too_many(vertices, faces, length, least, face_limit)
        if not parts.halve(length):
            break
    corners, parents = parts.all()
    order = np.argsort(parents, kind="stable")
    parameters = {"max_edge_length": length, "version": _VERSION}
    return DerivedMesh(
        derived_uuid(parent_uuid, "refinement", parameters),
        parent_uuid,
        parts.vertices,
        corners[order],
        face_parents=parents[order],
        vertex_parents=parts.sources,
        vertex_weights=parts.weights,
        parent_vertex_count=len(vertices),
        parent_face_count=len(faces),
    )


def least_faces(vertices: np.ndarray, faces: np.ndarray, max_edge_length: float) -> int:
    """So many faces at least a refinement has: none is larger than the equilateral triangle of that
    edge, and no longer than the edge. There are about three times as many where faces are large.
    """
    a, b, c = vertices[faces].astype(np.float64).transpose(1, 0, 2)
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = _lengths(vertices, faces).max(1, initial=0.0)
    by_area = areas / (np.sqrt(3.0) / 4.0 * max_edge_length**2)
    return int(np.ceil(np.maximum(np.maximum(by_area, longest / max_edge_length), 1.0)).sum())


def _too_many(
    vertices: np.ndarray, faces: np.ndarray, length: float, least: int, limit: int
) -> MeshMapError:
    text = "max_edge_length %g m makes at least %s faces of %s, more than %s"
    numbers = tuple(format(number, ",") for number in (least, len(faces), limit))
    longer, longest = length, float(_lengths(vertices, faces).max())
    while longer < longest and _SURELY * least_faces(vertices, faces, longer) > limit:
        longer = float("%.2g" % (1.25 * longer))
    hint = "%.2g m would do" % longer if longer < longest else "leave it out for this mesh"
    return MeshMapError(text % ((length,) + numbers), hint)


def _check_steps(vertices: np.ndarray, length: float) -> None:
    step = float(np.spacing(np.abs(vertices).max(initial=0.0)))
    if length < _STEPS * step:
        raise MeshMapError(
            "max_edge_length %g m is too short: coordinates here are multiples of %.2g m"
            % (length, step),
            "%.2g m or more, or an origin near the mesh" % (_STEPS * step),
        )


class _Parts:
    """The mesh as far as it has been refined: triangles, and strips of faces that become ladders.

    A strip (m, b, c, q) has short ends, m to q and b to c, which are not halved any more.

    Attributes:
        vertices: (V, 3) float32; sources, weights: (V, 3), see DerivedMesh.
        corners: (F, 3) int64, of triangles that may have to be cut; parents: (F,) int64.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        count = len(vertices)
        self._parent_vertices = vertices.astype(np.float64)
        self._parent_faces = faces.astype(np.int64)
        self.vertices = vertices
        self.sources = np.repeat(np.arange(count)[:, None], 3, axis=1)
        self.weights = np.tile([1.0, 0.0, 0.0], (count, 1))
        self.corners = self._parent_faces
        self.parents = np.arange(len(faces))
        self._strips = np.zeros((0, 4), np.int64)
        self._strip_parents = np.zeros(0, np.int64)
        self._done: List[Tuple[np.ndarray, np.ndarray]] = []

    @property
    def done_count(self) -> int:
        """Of triangles that are short enough."""
        return sum(len(corners) for corners, _ in self._done)

    def all(self) -> Tuple[np.ndarray, np.ndarray]:
        """Corners and parents of what is short enough."""
        corners, parents = zip(*self._done)
        return np.concatenate(corners), np.concatenate(parents)

    def halve(self, length: float) -> bool:
        """Halves all edges that are longer, once; False where there are none."""
        self._dissolve(length)
        lengths = _lengths(self.vertices, self.corners)
        marked = lengths > length
        is_halved = marked.any(1)
        self._done.append((self.corners[~is_halved], self.parents[~is_halved]))
        if not is_halved.any() and not len(self._strips):
            return False
        # Each triangle from the beginning of its longest edge on; strips as four edges.
        turn = (lengths[is_halved].argmax(1)[:, None] + np.arange(3)) % 3
        triangles = np.take_along_axis(self.corners[is_halved], turn, 1)
        marked = np.take_along_axis(marked[is_halved], turn, 1)
        parents, strips, strip_parents = self.parents[is_halved], self._strips, self._strip_parents
        sides = _lengths(self.vertices, strips) > length
        sides[:, [1, 3]] = False
        middles, strip_middles = self._middles(
            [(triangles, marked, parents), (strips, sides, strip_parents)]
        )
        self.corners, self.parents = np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
        self._strips, self._strip_parents = np.zeros((0, 4), np.int64), np.zeros(0, np.int64)
        self._cut_triangles(triangles, marked, middles, parents)
        self._cut_strips(strips, sides, strip_middles, strip_parents)
        return True

    def _dissolve(self, length: float) -> None:
        """Makes triangles of strips that are short enough (or, by rounding, too wide)."""
        lengths = _lengths(self.vertices, self._strips)
        is_done = (lengths[:, [0, 2]] <= length).all(1) | (lengths[:, [1, 3]] > length).any(1)
        m, b, c, q = self._strips[is_done].T
        parents = self._strip_parents[is_done]
        across = _lengths(self.vertices, np.stack([m, c, b, q], 1))
        is_shorter = across[:, 0] <= across[:, 2]
        self._add(parents, is_shorter, (m, b, c), (m, c, q))
        self._add(parents, ~is_shorter, (m, b, q), (b, c, q))
        self._strips = self._strips[~is_done]
        self._strip_parents = self._strip_parents[~is_done]

    def _cut_triangles(
        self, corners: np.ndarray, marked: np.ndarray, middles: np.ndarray, parents: np.ndarray
    ) -> None:
        """The longest edge is ab."""
        (a, b, c), (ab, bc, ca) = corners.T, middles.T
        _, has_bc, has_ca = marked.T
        self._add(parents, ~has_bc & ~has_ca, (a, ab, c), (ab, b, c))
        self._add(parents, has_bc & has_ca, (a, ab, ca), (ab, c, ca), (ab, b, bc), (ab, bc, c))
        for where, tip, strip in (
            (has_ca & ~has_bc, (a, ab, ca), (ab, b, c, ca)),
            (has_bc & ~has_ca, (b, bc, ab), (bc, c, a, ab)),
        ):
            self._add(parents, where, tip)
            self._add_strips(parents, where, strip)

    def _cut_strips(
        self, corners: np.ndarray, marked: np.ndarray, middles: np.ndarray, parents: np.ndarray
    ) -> None:
        (m, b, c, q), (mb, _, cq, _) = corners.T, middles.T
        has_mb, has_cq = marked[:, 0], marked[:, 2]
        self._add_strips(parents, has_mb & has_cq, (m, mb, cq, q), (mb, b, c, cq))
        self._add(parents, has_mb & ~has_cq, (m, mb, q), (mb, c, q), (mb, b, c))
        self._add(parents, has_cq & ~has_mb, (m, cq, q), (m, b, cq), (b, c, cq))

    def _add(self, parents: np.ndarray, where: np.ndarray, *made: Any) -> None:
        parts = [np.stack(corners, 1)[where] for corners in made]
        self.corners = np.concatenate([self.corners, *parts])
        self.parents = np.concatenate([self.parents] + [parents[where]] * len(made))

    def _add_strips(self, parents: np.ndarray, where: np.ndarray, *made: Any) -> None:
        parts = [np.stack(corners, 1)[where] for corners in made]
        self._strips = np.concatenate([self._strips, *parts])
        self._strip_parents = np.concatenate([self._strip_parents] + [parents[where]] * len(made))

    def _middles(
        self, polygons: List[Tuple[np.ndarray, np.ndarray, np.ndarray]]
    ) -> List[np.ndarray]:
        """Of polygons (corners, whether the edge to the next corner is to be halved, parents): the
        vertices in the middle of these edges, made here; 0 elsewhere."""
        places = [np.nonzero(marked) for _, marked, _ in polygons]
        ends = np.concatenate(
            [
                np.stack([corners[row, column], np.roll(corners, -1, 1)[row, column]], 1)
                for (corners, _, _), (row, column) in zip(polygons, places)
            ]
        )
        parents = np.concatenate([of[row] for (_, _, of), (row, _) in zip(polygons, places)])
        keys = ends.min(1) * len(self.vertices) + ends.max(1)
        _, first, numbers = np.unique(keys, return_index=True, return_inverse=True)
        numbers = len(self.vertices) + numbers.ravel()
        self._make(ends[first], self._parent_faces[parents[first]])
        found = []
        for (corners, _, _), (row, column) in zip(polygons, places):
            middles = np.zeros(corners.shape, np.int64)
            middles[row, column], numbers = numbers[: len(row)], numbers[len(row) :]
            found.append(middles)
        return found

    def _make(self, ends: np.ndarray, of_face: np.ndarray) -> None:
        """Adds the vertices in the middle of edges (K, 2) in faces of the parent (K, 3)."""
        weights = 0.5 * (
            self._weights_in(of_face, ends[:, 0]) + self._weights_in(of_face, ends[:, 1])
        )
        order = np.argsort(-weights, axis=1, kind="stable")
        weights = np.take_along_axis(weights, order, 1)
        sources = np.take_along_axis(of_face, order, 1)
        sources = np.where(weights > 0.0, sources, sources[:, :1])
        points = np.einsum("ij,ijk->ik", weights, self._parent_vertices[sources])
        self.vertices = np.concatenate([self.vertices, points.astype(np.float32)])
        self.sources = np.concatenate([self.sources, sources])
        self.weights = np.concatenate([self.weights, weights])

    def _weights_in(self, of_face: np.ndarray, vertices: np.ndarray) -> np.ndarray:
        """(K, 3) by which vertices are between the corners (K, 3) of the parent's faces."""
        sources, weights = self.sources[vertices], self.weights[vertices]
        found = ((sources[:, None, :] == of_face[:, :, None]) * weights[:, None, :]).sum(2)
        # A corner that a face has twice counts once.
        found[:, 1][of_face[:, 1] == of_face[:, 0]] = 0.0
        found[:, 2][(of_face[:, 2] == of_face[:, 0]) | (of_face[:, 2] == of_face[:, 1])] = 0.0
        return found


def _lengths(vertices: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """(F, N) float64 of the edges from each corner of polygons (F, N) to the next one."""
    points = vertices[corners].astype(np.float64)
    return np.linalg.norm(np.roll(points, -1, 1) - points, axis=2)
