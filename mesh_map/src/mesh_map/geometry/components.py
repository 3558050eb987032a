"""Components of a mesh: what hangs together, and small ones dropped."""

from typing import Any, NamedTuple, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh, derived_uuid

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.submesh import checked_mesh, submesh
from mesh_map.geometry.topology import Topology

_VERSION = 1  # another number gives all results other UUIDs


class Components(NamedTuple):
    """Faces that edges connect, with sizes. Vertices without faces are none.

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


def components(vertices: Any, faces: Any, topology: Optional[Topology] = None) -> Components:
    """What hangs together.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        topology: of these faces, if it is known.
    Raises:
        MeshMapError: no mesh: what is wrong.
    """
    vertices, faces = checked_mesh(vertices, faces)
    if topology is None:
        topology = Topology(faces=faces, vertex_count=len(vertices))
    of_faces = topology.components[faces[:, 0]]
    counts = np.bincount(of_faces, minlength=topology.component_count)
    areas = np.bincount(of_faces, face_areas(vertices, faces), topology.component_count)
    first = np.full(topology.component_count, len(faces))
    first[of_faces[::-1]] = np.arange(len(faces))[::-1]
    numbers = np.flatnonzero(counts)
    order = numbers[np.lexsort((first[numbers], -areas[numbers]))]
    rank = np.zeros(topology.component_count, np.int64)
    rank[order] = np.arange(len(order))
    return Components(rank[of_faces], counts[order], areas[order])


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
    parent_uuid: str = "",
) -> Optional[DerivedMesh]:
    """The mesh without components that are too small; the one with the largest area always stays.

    Args:
        vertices: (V, 3) meters.
        faces: (F, 3) vertex indices.
        min_faces: components of fewer faces are dropped.
        min_share: components with less than this part (0 to 1) of the area of the mesh, too.
        parent_uuid: identity of the mesh; that of the result follows from it.
    Returns:
        Faces and vertices in their order; None where nothing is dropped.
    Raises:
        MeshMapError: a share that is not from 0 to 1; no mesh: what is wrong.
    """
    if not 0.0 <= min_share <= 1.0:
        raise MeshMapError("min_share is %g, but it has to be from 0 to 1" % min_share)
    vertices, faces = checked_mesh(vertices, faces)
    found = components(vertices, faces)
    kept = found.face_counts >= min_faces
    kept &= found.areas >= min_share * found.areas.sum()
    kept[:1] = True
    if kept.all():
        return None
    parameters = {"min_faces": min_faces, "min_share": min_share, "version": _VERSION}
    uuid = derived_uuid(parent_uuid, "large components", parameters)
    return submesh(vertices, faces, np.flatnonzero(kept[found.of_faces]), uuid, parent_uuid)
