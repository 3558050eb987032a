"""A derived mesh of some of the faces of a mesh."""

from typing import Any, Tuple

import numpy as np
from mesh_msgs.checks.mesh_arrays import as_faces, as_vertices
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs.validation import check_geometry

from mesh_map.base.errors import MeshMapError


def checked_mesh(vertices: Any, faces: Any) -> Tuple[np.ndarray, np.ndarray]:
    """(vertices (V, 3) float32, faces (F, 3) uint32) of a mesh that something is derived of.

    Raises:
        MeshMapError: no mesh: what is wrong, where, and how often.
    """
    findings = check_geometry(vertices, faces)
    if findings:
        raise MeshMapError("no usable mesh: %s" % (findings[0],))
    return as_vertices(vertices), as_faces(faces)


def submesh(
    vertices: np.ndarray, faces: np.ndarray, kept: np.ndarray, uuid: str, parent_uuid: str
) -> DerivedMesh:
    """Faces of a mesh and their vertices, in their order.

    Args:
        vertices, faces: of checked_mesh().
        kept: (K,) the faces, ascending.
        uuid, parent_uuid: identities.
    """
    chosen = faces[kept]
    is_used = np.zeros(len(vertices), bool)
    is_used[chosen] = True
    used = np.flatnonzero(is_used)
    numbers = np.cumsum(is_used, dtype=np.int64) - 1
    return DerivedMesh(
        uuid,
        parent_uuid,
        vertices[used],
        numbers[chosen].astype(np.uint32),
        face_parents=kept,
        vertex_parents=used[:, None],
        vertex_weights=np.ones((len(used), 1)),
        parent_vertex_count=len(vertices),
        parent_face_count=len(faces),
    )
