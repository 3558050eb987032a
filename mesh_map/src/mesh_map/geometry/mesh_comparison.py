"""How good a reconstructed mesh is: accuracy and completeness against the truth, and soundness."""

from typing import Any, Dict, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.border_loops import border_loops
from mesh_map.geometry.components import components, face_areas
from mesh_map.geometry.crop import Region
from mesh_map.geometry.normals import face_normals
from mesh_map.geometry.submesh import checked_mesh
from mesh_map.geometry.topology import Topology
from mesh_map.spatial.hits import NO_FACE
from mesh_map.spatial.spatial_index import SpatialIndex

SAMPLES = 200_000


class Distances(NamedTuple):
    """Distances of points sampled by area on one surface from another one, in meters.

    count: points. mean, p95, max: of the distances. share_within: part of them, 0 to 1, that is at
    most the tolerance.
    """

    count: int
    mean: float
    p95: float
    max: float
    share_within: float


class Soundness(NamedTuple):
    """What a mesh is like by itself.

    border_loops, open_border_edges: see BorderLoops. share_outside_largest: part of the faces, 0 to
    1, that is not in the component with most of them. The others: see Topology.
    """

    faces: int
    components: int
    share_outside_largest: float
    border_loops: int
    open_border_edges: int
    non_manifold_edges: int
    inconsistent_edges: int
    degenerate_faces: int


class MeshComparison(NamedTuple):
    """A mesh beside the truth.

    accuracy: of points on the mesh, from the truth. completeness: of points on the truth, from the
    mesh. share_flipped: part of the points on the mesh, 0 to 1, within the tolerance of the truth
    that only have faces of it there which show the other side. truth, mesh: each by itself.
    """

    accuracy: Distances
    completeness: Distances
    share_flipped: float
    truth: Soundness
    mesh: Soundness

    def values(self) -> Dict[str, Any]:
        """What json can write."""
        return {
            name: value._asdict() if hasattr(value, "_asdict") else value
            for name, value in self._asdict().items()
        }


def compare_meshes(
    truth_vertices: Any,
    truth_faces: Any,
    vertices: Any,
    faces: Any,
    *,
    tolerance: float = 0.05,
    samples: int = SAMPLES,
    seed: int = 0,
    within: Optional[Region] = None,
    reached: Optional[Any] = None,
) -> MeshComparison:
    """Measures a mesh against the truth, as reconstructions usually are (accuracy and completeness
    as in A. Knapitsch et al.: Tanks and Temples, 2017).

    Args:
        truth_vertices, truth_faces: (V, 3) meters and (F, 3) vertex indices of the truth.
        vertices, faces: of the mesh, in the same frame.
        tolerance: meters, above 0.
        samples: points on each surface, spread evenly by area.
        seed: of the points; the result depends on the arguments alone.
        within: only points in it count, on both surfaces.
        reached: (F,) bool, the faces of the truth that sensors have seen: only these have to be
            there. None for all.
    Raises:
        MeshMapError: no mesh: what is wrong; a number out of its range; no surface to be measured.
        ValueError: another number of values in reached than faces.
    """
    if not tolerance > 0.0:
        raise MeshMapError("tolerance is %g, but it has to be above 0" % tolerance)
    if samples < 1:
        raise MeshMapError("samples is %d, but it has to be 1 or more" % samples)
    truth_vertices, truth_faces = checked_mesh(truth_vertices, truth_faces)
    vertices, faces = checked_mesh(vertices, faces)
    wanted = np.ones(len(truth_faces), bool)
    if reached is not None:
        wanted = np.asarray(reached)
        if wanted.shape != (len(truth_faces),) or wanted.dtype != bool:
            raise ValueError(
                "reached needs a boolean for each of %d faces of the truth, not the shape %s of %s"
                % (len(truth_faces), wanted.shape, wanted.dtype)
            )
    rng = np.random.default_rng(seed)
    truth_index, index = SpatialIndex(truth_vertices, truth_faces), SpatialIndex(vertices, faces)
    everywhere = np.ones(len(faces), bool)
    points, of_faces = _sampled(vertices, faces, everywhere, samples, rng, within, "the mesh")
    near = truth_index.closest_batch(points=points).distances
    flipped = _flipped(vertices, faces[of_faces], points, near, truth_index, tolerance)
    what = "the truth" if reached is None else "what was reached of the truth"
    truth_points, _ = _sampled(truth_vertices, truth_faces, wanted, samples, rng, within, what)
    missed = index.closest_batch(points=truth_points).distances
    return MeshComparison(
        _distances(near, tolerance),
        _distances(missed, tolerance),
        flipped,
        soundness(truth_vertices, truth_faces),
        soundness(vertices, faces),
    )


def soundness(vertices: Any, faces: Any) -> Soundness:
    """What a mesh is like by itself.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
    Raises:
        MeshMapError: no mesh: what is wrong.
    """
    vertices, faces = checked_mesh(vertices, faces)
    topology = Topology(faces=faces, vertex_count=len(vertices))
    pieces = components(vertices, faces, topology)
    loops = border_loops(faces, len(vertices))
    return Soundness(
        len(faces),
        pieces.count,
        pieces.share_outside_largest,
        loops.count,
        loops.open_edges,
        int(topology.non_manifold_edges.sum()),
        int(topology.inconsistent_edges.sum()),
        int(topology.degenerate_faces.sum()),
    )


def surface_samples(
    vertices: np.ndarray, faces: np.ndarray, count: int, rng: np.random.Generator
) -> Tuple[np.ndarray, np.ndarray]:
    """Points spread over a surface by area: (their places (count, 3), their faces (count,)).

    Args:
        vertices, faces: with some area.
        count: points, one in each of as many parts of the area.
        rng: where in these.
    """
    sums = np.cumsum(face_areas(vertices, faces))
    places = (np.arange(count) + rng.random(count)) / count * sums[-1]
    chosen = np.searchsorted(sums, places, side="right").clip(0, len(faces) - 1)
    root, second = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1.0 - root, root * (1.0 - second), root * second], axis=1)
    return np.einsum("ij,ijk->ik", weights, vertices[faces[chosen]].astype(np.float64)), chosen


def _sampled(
    vertices: np.ndarray,
    faces: np.ndarray,
    wanted: np.ndarray,
    count: int,
    rng: np.random.Generator,
    within: Optional[Region],
    what: str,
) -> Tuple[np.ndarray, np.ndarray]:
    numbers = np.flatnonzero(wanted)
    if not len(numbers) or not face_areas(vertices, faces[numbers]).sum() > 0.0:
        raise MeshMapError("%s has no surface to be measured" % what)
    points, chosen = surface_samples(vertices, faces[numbers], count, rng)
    inside = np.ones(len(points), bool) if within is None else within.contains(points)
    if not inside.any():
        raise MeshMapError("nothing of %s is in the region" % what)
    return points[inside], numbers[chosen[inside]]


def _distances(distances: np.ndarray, tolerance: float) -> Distances:
    return Distances(
        len(distances),
        float(distances.mean()),
        float(np.percentile(distances, 95)),
        float(distances.max()),
        float((distances <= tolerance).mean()),
    )


def _flipped(
    vertices: np.ndarray,
    faces: np.ndarray,
    points: np.ndarray,
    distances: np.ndarray,
    truth: SpatialIndex,
    tolerance: float,
) -> float:
    """Part of the points near the truth where it shows the other side only."""
    near = distances <= tolerance
    if not near.any():
        return 0.0
    normals = face_normals(vertices, faces[near])[0]
    found = truth.closest_batch(
        points=points[near],
        max_distance=tolerance,
        normals=normals.astype(np.float64),
        max_angle=0.5 * np.pi,
    )
    return float((found.faces == NO_FACE).mean())
