"""What others take for the same: SciPy, and potpourri3d and pygeodesic where they are installed."""

from typing import Any, Callable, List, NamedTuple, Optional, Tuple

import numpy as np
from mesh_map.geometry.topology import Topology
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra


class Ground(NamedTuple):
    """The largest component alone: these need a manifold. `numbers` (N,) are its vertices."""

    vertices: np.ndarray
    faces: np.ndarray
    numbers: np.ndarray
    source: int


def snapshot_of(world: Any, radius: float = np.inf) -> Ground:
    """That of a PlanningWorld, without faces at edges of more than two.

    Only faces with a corner within the radius (m) of the source: no way to there that is as short
    leaves them.
    """
    counts = world.topology.edge_face_counts[world.topology.face_edges]
    offsets = world.vertices - world.vertices[world.source]
    usable = world.ground & (np.linalg.norm(offsets, axis=1) <= radius)
    faces = world.faces[usable[world.faces].any(axis=1) & (counts <= 2).all(axis=1)]
    numbers = np.unique(faces)
    return Ground(
        world.vertices[numbers].astype(np.float64),
        np.searchsorted(numbers, faces).astype(np.int32),
        numbers,
        int(np.searchsorted(numbers, world.source)),
    )


def scipy_graph(topology: Topology, weights: np.ndarray) -> csr_matrix:
    """The edges as SciPy takes them; made once, and not part of a time."""
    shape = (topology.vertex_count, topology.vertex_count)
    values = weights[topology.neighbor_edges].astype(np.float64)
    return csr_matrix((values, topology.neighbors, topology.neighbor_offsets), shape)


def scipy_distances(graph: csr_matrix, source: int) -> np.ndarray:
    """(V,) of Dijkstra's algorithm."""
    return dijkstra(graph, indices=source)


Prepared = Tuple[str, Callable[[], Callable[[int], np.ndarray]]]


def installed(ground: Ground) -> List[Prepared]:
    """(name, function that prepares and returns one from source to distances) of each peer."""
    found: List[Prepared] = []
    try:
        import potpourri3d

        found += [
            ("potpourri3d FMM", lambda: _marching(potpourri3d, ground)),
            ("potpourri3d heat", lambda: _heat(potpourri3d, ground)),
        ]
    except ImportError:
        pass
    return found


def _marching(library: Any, ground: Ground) -> Callable[[int], np.ndarray]:
    solver = library.MeshFastMarchingDistanceSolver(ground.vertices, ground.faces)
    return lambda source: solver.compute_distance([[(source, [])]])


def _heat(library: Any, ground: Ground) -> Callable[[int], np.ndarray]:
    solver = library.MeshHeatMethodDistanceSolver(ground.vertices, ground.faces)
    return solver.compute_distance


def exact_solver(ground: Ground) -> Optional[Callable[[int], np.ndarray]]:
    """Exact geodesic distances by pygeodesic: minutes and 8 GB at a million vertices."""
    try:
        from pygeodesic import geodesic
    except ImportError:
        return None
    algorithm = geodesic.PyGeodesicAlgorithmExact(ground.vertices, ground.faces)
    return lambda source: algorithm.geodesicDistances(np.array([source]), None)[0]
