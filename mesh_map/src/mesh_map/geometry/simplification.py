"""Simplification: a derived mesh of fewer faces on some of the same vertices."""

import math
from typing import Any, NamedTuple, Optional, Set, Tuple

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh, derived_uuid

from mesh_map import _kernels
from mesh_map.base.digest import digest
from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.normals import face_normals
from mesh_map.geometry.submesh import checked_mesh, submesh
from mesh_map.geometry.topology import Topology
from mesh_map.spatial.spatial_index import SpatialIndex

_VERSION = 1  # another number gives all results other UUIDs
_FLIP_ROUNDS = 8
_FLAT = 0.2  # cosine between a face that was flipped and the one that was there


class Simplification(NamedTuple):
    """What simplify() has made.

    derived: the mesh, or None where no face could be spared.
    max_distance: meters; no vertex of the mesh is farther from the surface of the result.
    kept_faces: faces of the mesh that were kept as they are, as it would have got a fault there.
    """

    derived: Optional[DerivedMesh]
    max_distance: float
    kept_faces: int


def simplify(
    vertices: Any,
    faces: Any,
    *,
    max_error: float = math.inf,
    face_count: Optional[int] = None,
    ratio: Optional[float] = None,
    regions: Optional[Any] = None,
    originals: Optional[Any] = None,
    parent_uuid: str = "",
) -> Simplification:
    """Fewer faces, by edge collapses of meshoptimizer (after M. Garland and P. Heckbert: Surface
    simplification using quadric error metrics, 1997).

    Vertices on the border stay, and those between regions; so do the edges there. Vertices of the
    result are vertices of the mesh and have their values. No edge has more than two faces that has
    not had them before, no face is turned over, and no vertex that is left out is farther from the
    result than max_error: where one would be, the faces around stay as they are.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        max_error: meters; infinite where only the number of faces counts.
        face_count: so many faces are enough; None for as few as the error allows.
        ratio: the same as a part of the faces, above 0 to 1; with face_count the larger counts.
        regions: (F,) whole numbers: faces of one region are simplified by themselves, such as those
            of one label. None for one region.
        originals: (V,) vertex indices: for each vertex that it is a copy of along a seam, and else
            itself. Seams are borders, but the mesh without copies gets no fault either.
        parent_uuid: identity of the mesh; that of the result follows from it.
    Returns:
        Vertices in their order; faces whose parents are of their region: the nearest to the middle.
    Raises:
        MeshMapError: neither an error nor a number of faces, or one out of its range; a build
            without meshoptimizer; no mesh: what is wrong.
        ValueError: another number of regions than faces, or of originals than vertices.
    """
    target = _target(faces, max_error, face_count, ratio)
    if not _kernels._CAN_SIMPLIFY:
        raise MeshMapError(
            "mesh_map was built without meshoptimizer, so it cannot simplify meshes",
            "install libmeshoptimizer-dev 0.18 or newer, and build again",
        )
    vertices, faces = checked_mesh(vertices, faces)
    numbers = _numbered(regions, len(faces))
    surface = _Surface(vertices, faces, numbers, _checked_originals(originals, len(vertices)))
    frozen = np.zeros(len(faces), np.uint8)
    while True:
        found, found_regions, _ = _kernels._simplification(
            vertices, faces, numbers, frozen, target, max_error
        )
        is_fin = surface.fins(found, found_regions)
        found, found_regions = found[~is_fin], found_regions[~is_fin]
        found, parents, turned = surface.unfolded(found, found_regions)
        bad, distance = surface.faults(found, found_regions, turned, max_error)
        if not bad.any():
            break
        around = bad[faces].any(axis=1)
        if (frozen[around] != 0).all():
            break
        frozen[around] = 1

    kept = int(np.count_nonzero(frozen))
    if len(found) == len(faces):
        return Simplification(None, 0.0, kept)
    order = np.lexsort((np.arange(len(parents)), parents))
    parameters = {
        "max_error": max_error if math.isfinite(max_error) else "inf",
        "target": target,
        "regions": None if regions is None else digest(numbers),
        "version": _VERSION,
    }
    uuid = derived_uuid(parent_uuid, "simplification", parameters)
    derived = _on_vertices(vertices, faces, found[order], parents[order], uuid, parent_uuid)
    return Simplification(derived, distance, kept)


def _target(faces: Any, max_error: float, face_count: Optional[int], ratio: Optional[float]) -> int:
    if not max_error >= 0.0:
        raise MeshMapError("max_error is %g, but it has to be 0 or more" % max_error)
    if face_count is None and ratio is None and math.isinf(max_error):
        raise MeshMapError(
            "there is nothing to simplify to", "max_error, face_count or ratio says how far"
        )
    if face_count is not None and face_count < 1:
        raise MeshMapError("face_count is %d, but it has to be 1 or more" % face_count)
    if ratio is not None and not 0.0 < ratio <= 1.0:
        raise MeshMapError("ratio is %g, but it has to be above 0, and 1 at most" % ratio)
    by_ratio = 0 if ratio is None else int(round(ratio * len(faces)))
    return max(face_count or 0, by_ratio)


def _numbered(regions: Optional[Any], count: int) -> np.ndarray:
    if regions is None:
        return np.zeros(count, np.uint32)
    values = np.asarray(regions)
    if values.shape != (count,) or values.dtype.kind not in "iub":
        raise ValueError(
            "regions need one whole number for each of %d faces, not the shape %s of %s"
            % (count, values.shape, values.dtype)
        )
    return np.unique(values, return_inverse=True)[1].reshape(-1).astype(np.uint32)


def _checked_originals(originals: Optional[Any], count: int) -> np.ndarray:
    if originals is None:
        return np.arange(count, dtype=np.uint32)
    values = np.asarray(originals)
    is_right = values.shape == (count,) and values.dtype.kind in "iu"
    if not is_right or (values < 0).any() or (values >= count).any():
        raise ValueError("originals need the index of a vertex for each of %d vertices" % count)
    return values.astype(np.uint32)


class _Surface:
    """The mesh before, and what of a simplified one does not go with it."""

    def __init__(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        regions: np.ndarray,
        originals: np.ndarray,
    ) -> None:
        self._vertices, self._faces, self._regions = vertices, faces, regions
        self._originals = originals
        self._index = SpatialIndex(vertices, faces)
        normals, without_area = face_normals(vertices, faces)
        self._normals = np.where(without_area[:, None], np.float32(0.0), normals)
        self._topology = self._topology_of(faces)
        self._old_faults = _edge_keys(self._topology, _faulty(self._topology))
        parting = _parting(self._topology, regions)
        self._old_borders = _edge_keys(self._topology, self._topology.border_edges | parting)
        self._used = np.zeros(len(vertices), bool)
        self._used[originals[faces]] = True

    def _topology_of(self, faces: np.ndarray) -> Topology:
        """That of the mesh without copies."""
        return Topology(faces=self._originals[faces], vertex_count=len(self._vertices))

    def fins(self, faces: np.ndarray, regions: np.ndarray) -> np.ndarray:
        """(N,) bool: pairs of faces of a region back to back, which edge collapses leave behind
        where they fold a piece of surface up; without them the surface goes on below.

        Those that the mesh has had are none.
        """
        is_fin = np.zeros(len(faces), bool)
        topology = Topology(faces=faces, vertex_count=len(self._vertices))
        if not topology.duplicate_faces.any():
            return is_fin
        in_question = np.zeros(len(self._vertices), bool)
        in_question[faces[topology.duplicate_faces]] = True
        places = np.flatnonzero(in_question[faces].all(axis=1))
        rows, which = _ordered(faces[places])
        of_region = np.column_stack([rows, regions[places]])
        _, number, counts = np.unique(of_region, axis=0, return_inverse=True, return_counts=True)
        number = number.reshape(-1)
        fronts = np.bincount(number, which, len(counts))
        own = np.zeros(len(counts), bool)
        if self._topology.duplicate_faces.any():
            old = np.unique(_ordered(self._faces[self._topology.duplicate_faces])[0], axis=0)
            both = np.concatenate([old, rows])
            numbers = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
            own[number[np.isin(numbers[len(old) :], numbers[: len(old)])]] = True
        pairs = (counts == 2) & (fronts == 1) & ~own
        is_fin[places] = pairs[number]
        return is_fin

    def unfolded(
        self, faces: np.ndarray, regions: np.ndarray
    ) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(the faces with edges flipped where a face was turned over and that turns it back; their
        parents; (N,) bool, which are turned over still)."""
        faces = faces.copy()
        parents, turned = self._parents(faces, regions)
        turned &= ~self._is_same(faces, parents)
        for _ in range(_FLIP_ROUNDS):
            changed = np.zeros(0, np.int64)
            if turned.any():
                changed = self._flip(faces, regions, np.flatnonzero(turned))
            if not len(changed):
                break
            parents[changed], turned[changed] = self._parents(faces[changed], regions[changed])
        return faces, parents, turned & ~self._is_same(faces, parents)

    def _flip(self, faces: np.ndarray, regions: np.ndarray, turned: np.ndarray) -> np.ndarray:
        """Flips one edge of each of these faces, where that helps; which faces have changed."""
        topology = Topology(faces=faces, vertex_count=len(self._vertices))
        keys = topology.edges[:, 0].astype(np.uint64) << np.uint64(32)
        keys |= topology.edges[:, 1].astype(np.uint64)
        edges = topology.face_edges[turned]
        starts = topology.edge_face_offsets[edges].astype(np.int64)
        pair = topology.edge_faces[np.stack([starts, starts + 1], 2).clip(0, 3 * len(faces) - 1)]
        other = np.where(pair[..., 0] == turned[:, None], pair[..., 1], pair[..., 0]).astype(int)
        a, b, c = (np.roll(faces[turned], -k, axis=1) for k in range(3))
        beside = faces[other]
        is_far = (beside != a[..., None]) & (beside != b[..., None])
        d = np.take_along_axis(beside, is_far.argmax(2)[..., None], 2)[..., 0]
        wanted = np.minimum(c, d).astype(np.uint64) << np.uint64(32)
        wanted |= np.maximum(c, d).astype(np.uint64)
        place = np.searchsorted(keys, wanted).clip(0, len(keys) - 1)
        points = self._vertices.astype(np.float64)

        def normal(*corners: np.ndarray) -> np.ndarray:
            p, q, r = (points[corner] for corner in corners)
            return np.cross(q - p, r - p)

        front = normal(b, a, d)
        fits = (topology.edge_face_counts[edges] == 2) & (is_far.sum(2) == 1)
        fits &= ~topology.edge_flags[edges].astype(bool) & (keys[place] != wanted)
        fits &= regions[other] == regions[turned][:, None]
        for new in (normal(a, d, c), normal(d, b, c)):
            lengths = np.linalg.norm(new, axis=2) * np.linalg.norm(front, axis=2)
            fits &= np.einsum("ijk,ijk->ij", new, front) > _FLAT * lengths
        changed: Set[int] = set()
        made: Set[int] = set()
        for row, k in zip(*np.nonzero(fits)):
            one, two, edge = int(turned[row]), int(other[row, k]), int(wanted[row, k])
            if one in changed or two in changed or edge in made:
                continue
            faces[one] = a[row, k], d[row, k], c[row, k]
            faces[two] = d[row, k], b[row, k], c[row, k]
            changed.update((one, two))
            made.add(edge)
        return np.array(sorted(changed), np.int64)

    def faults(
        self, faces: np.ndarray, regions: np.ndarray, turned: np.ndarray, max_error: float
    ) -> Tuple[np.ndarray, float]:
        """((V,) bool, vertices at which there is a fault; the largest distance in meters from a
        vertex to the faces, infinite where it was not needed)."""
        bad = np.zeros(len(self._vertices), bool)
        topology = self._topology_of(faces)
        keys = _edge_keys(topology, _faulty(topology))
        wrong = keys[~np.isin(keys, self._old_faults)]
        borders = _edge_keys(topology, topology.border_edges | _parting(topology, regions))
        wrong = np.concatenate([wrong, np.setxor1d(borders, self._old_borders, True)])
        components = np.zeros(self._topology.component_count, bool)
        components[self._topology.components[self._originals[faces[:, 0]]]] = True
        bad |= self._used & ~components[self._topology.components]
        bad[(wrong >> np.uint64(32)).astype(np.int64)] = True
        bad[(wrong & np.uint64(0xFFFFFFFF)).astype(np.int64)] = True
        bad = bad[self._originals]
        bad[faces[turned]] = True
        if bad.any() and math.isinf(max_error):
            return bad, math.inf  # it will be measured when the other faults are gone
        left_out = self._used.copy()
        left_out[self._originals[faces]] = False
        left_out = np.flatnonzero(left_out)
        if not len(left_out):
            return bad, 0.0
        if not len(faces):
            return bad, math.inf
        index = SpatialIndex(self._vertices, faces)
        distances = index.closest_batch(points=self._vertices[left_out]).distances
        bad[left_out[distances > max_error]] = True
        return bad, float(distances.max())

    def _is_same(self, faces: np.ndarray, parents: np.ndarray) -> np.ndarray:
        return (np.sort(faces, axis=1) == np.sort(self._faces[parents], axis=1)).all(axis=1)

    def _parents(self, faces: np.ndarray, regions: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """((N,) the faces of the mesh that are nearest to the middle of faces, of their regions;
        (N,) bool, which of these show the other side there, or none)"""
        middles = self._vertices[faces].mean(axis=1, dtype=np.float64)
        normals, without_area = face_normals(self._vertices, faces)
        found = self._index.closest_batch(points=middles).faces.astype(np.int64)

        def are_turned() -> np.ndarray:
            turned = np.einsum("ij,ij->i", normals, self._normals[found]) < 0.0
            return turned | without_area

        # Of another region, or the back of a thin sheet: the nearest at one of the corners, which
        # are vertices of the mesh. These are few.
        for face in np.flatnonzero((self._regions[found] != regions) | are_turned()):
            near = np.unique(
                np.concatenate([self._topology.faces_of(v) for v in self._originals[faces[face]]])
            )
            near = near[self._regions[near] == regions[face]]
            fits = near[self._normals[near] @ normals[face] >= 0.0]
            near = fits if len(fits) else near
            gaps = self._vertices[self._faces[near]].mean(axis=1, dtype=np.float64) - middles[face]
            found[face] = near[np.einsum("ij,ij->i", gaps, gaps).argmin()]
        return found, are_turned()


def _ordered(faces: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """(faces with their vertices in ascending order, which of them run that way round)."""
    first = faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces, (first + np.arange(3)) % 3, 1)
    return np.sort(faces, axis=1), turned[:, 1] < turned[:, 2]


def _faulty(topology: Topology) -> np.ndarray:
    return topology.non_manifold_edges | topology.inconsistent_edges


def _parting(topology: Topology, regions: np.ndarray) -> np.ndarray:
    """(E,) bool: edges of two faces, of different regions."""
    parting = topology.edge_face_counts == 2
    pairs = topology.edge_face_offsets[:-1][parting].astype(np.int64)
    one, other = topology.edge_faces[pairs], topology.edge_faces[pairs + 1]
    parting[parting] = regions[one] != regions[other]
    return parting


def _edge_keys(topology: Topology, which: np.ndarray) -> np.ndarray:
    edges = topology.edges[which].astype(np.uint64)
    return (edges[:, 0] << np.uint64(32)) | edges[:, 1]


def _on_vertices(
    vertices: np.ndarray,
    old_faces: np.ndarray,
    faces: np.ndarray,
    parents: np.ndarray,
    uuid: str,
    parent_uuid: str,
) -> DerivedMesh:
    """Other faces on vertices of a mesh."""
    whole = submesh(vertices, faces, np.arange(len(faces)), uuid, parent_uuid)
    return DerivedMesh(
        uuid,
        parent_uuid,
        whole.vertices,
        whole.faces,
        face_parents=parents,
        vertex_parents=whole.vertex_parents,
        vertex_weights=whole.vertex_weights,
        parent_vertex_count=len(vertices),
        parent_face_count=len(old_faces),
    )
