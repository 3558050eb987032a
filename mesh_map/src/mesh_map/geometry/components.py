"""Components of a mesh: what hangs together, and small ones dropped."""

from typing import Any, Dict, NamedTuple, Optional, Tuple

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh, derived_uuid
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.submesh import checked_mesh, submesh
from mesh_map.geometry.topology import Topology

_VERSION = 1  # another number gives all results other UUIDs


class Components(NamedTuple):
    """Faces that edges or vertices connect, with sizes. Vertices without faces are none.

    of_faces: (F,) int64, numbered from 0, the largest area first (then the lowest face).
    face_counts: (C,) int64.
    areas: (C,) float64, square meters.
    """

    of_faces: np.ndarray
    face_counts: np.ndarray
    areas: np.ndarray

    @property
    def count(self) -> int:
        """C."""
        return len(self.face_counts)

    @property
    def share_outside_largest(self) -> float:
        """Part of the faces, 0 to 1, that are not in the component with most of them."""
        total = len(self.of_faces)
        return 1.0 - float(self.face_counts.max()) / total if total else 0.0


def components(
    vertices: Any,
    faces: Any,
    topology: Optional[Topology] = None,
    *,
    across_vertices: bool = True,
) -> Components:
    """What hangs together.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        topology: of these faces, if it is known.
        across_vertices: False where faces that share a vertex, but no edge on the way around it,
            are not together.
    Raises:
        MeshMapError: no mesh: what is wrong.
    """
    vertices, faces = checked_mesh(vertices, faces)
    if topology is None:
        topology = Topology(faces=faces, vertex_count=len(vertices))
    if across_vertices:
        of_faces, count = topology.components[faces[:, 0]], topology.component_count
    else:
        of_faces, count = _edge_components(topology)
    counts = np.bincount(of_faces, minlength=count)
    areas = np.bincount(of_faces, face_areas(vertices, faces), count)
    first = np.full(count, len(faces))
    first[of_faces[::-1]] = np.arange(len(faces))[::-1]
    numbers = np.flatnonzero(counts)
    order = numbers[np.lexsort((first[numbers], -areas[numbers]))]
    rank = np.zeros(count, np.int64)
    rank[order] = np.arange(len(order))
    return Components(rank[of_faces], counts[order], areas[order])


def _edge_components(topology: Topology) -> Tuple[np.ndarray, int]:
    """(F,) the number of what hangs together by edges; how many there are."""
    beside = topology.edge_faces.astype(np.int64)
    at = np.repeat(np.arange(topology.edge_count), np.diff(topology.edge_face_offsets))
    together = np.flatnonzero(at[1:] == at[:-1])
    count = len(topology.face_edges)
    pairs = beside[together], beside[together + 1]
    graph = coo_matrix((np.ones(len(together), np.int8), pairs), shape=(count, count))
    number, of_faces = connected_components(graph, directed=False)
    return of_faces.astype(np.int64), number


def face_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,) float64 square meters."""
    a, b, c = vertices[faces].astype(np.float64).transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def drop_components(
    vertices: Any,
    faces: Any,
    *,
    min_faces: int = 0,
    min_share: float = 0.0,
    across_vertices: bool = True,
    parent_uuid: str = "",
) -> Optional[DerivedMesh]:
    """The mesh without components that are too small; the one with the largest area always stays.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        min_faces: components of fewer faces are dropped.
        min_share: components with less than this part (0 to 1) of the area of the mesh, too.
        across_vertices: see components().
        parent_uuid: identity of the mesh; that of the result follows from it.
    Returns:
        Faces and vertices in their order; None where nothing is dropped.
    Raises:
        MeshMapError: a share that is not from 0 to 1; no mesh: what is wrong.
    """
    if not 0.0 <= min_share <= 1.0:
        raise MeshMapError("min_share is %g, but it has to be from 0 to 1" % min_share)
    vertices, faces = checked_mesh(vertices, faces)
    found = components(vertices, faces, across_vertices=across_vertices)
    kept = found.face_counts >= min_faces
    kept &= found.areas >= min_share * found.areas.sum()
    kept[:1] = True
    if kept.all():
        return None
    parameters: Dict[str, Any] = {
        "min_faces": min_faces,
        "min_share": min_share,
        "version": _VERSION,
    }
    if not across_vertices:
        parameters["across_vertices"] = False
    uuid = derived_uuid(parent_uuid, "large components", parameters)
    return submesh(vertices, faces, np.flatnonzero(kept[found.of_faces]), uuid, parent_uuid)
