"""Rims of a surface taken away: where measurements end, a field bends away from what they met."""

from typing import Any, List, Optional

import numpy as np
from mesh_msgs.derived_mesh import DerivedMesh

from mesh_map.geometry.submesh import checked_mesh, submesh
from mesh_map.geometry.topology import Topology

_CURLED = np.cos(np.radians(60.0))
_ROWS = 3


def trim_rim(vertices: Any, faces: Any) -> Optional[DerivedMesh]:
    """The mesh without faces at its border that are turned by more than 60 degrees from those
    behind them, which are not at the border; three rows of such faces at most.

    Args:
        vertices: (V, 3) m.
        faces: (F, 3) vertex indices.
    Returns:
        None where there are none, or no others.
    Raises:
        MeshMapError: no mesh: what is wrong.
    """
    vertices, faces = checked_mesh(vertices, faces)
    topology = Topology(faces=faces, vertex_count=len(vertices))
    at_border = np.zeros(len(vertices), bool)
    at_border[topology.edges[topology.border_edges]] = True
    near = at_border.copy()
    for _ in range(_ROWS + 2):
        near[faces[near[faces].any(axis=1)]] = True
    left = np.flatnonzero(near[faces].any(axis=1))  # faces that the rim, or what is behind, has
    is_kept = np.ones(len(faces), bool)
    for _ in range(_ROWS):
        curled = _curled(vertices, faces[left], at_border)
        is_kept[left[curled]] = False
        at_border[faces[left[curled]]] = True
        left = left[~curled]
    if is_kept.all() or not is_kept.any():
        return None
    return submesh(vertices, faces, np.flatnonzero(is_kept), "", "")


def without_faces_at(vertices: Any, faces: Any, loops: List[np.ndarray]) -> Optional[DerivedMesh]:
    """The mesh without the faces at some vertices, such as those of loops of its border.

    Args:
        vertices: (V, 3) m.
        faces: (F, 3) vertex indices.
        loops: of vertex indices.
    Returns:
        None where nothing would be left.
    """
    is_gone = np.zeros(len(vertices), bool)
    is_gone[np.concatenate(loops)] = True
    kept = np.flatnonzero(~is_gone[faces].any(axis=1))
    return submesh(vertices, faces, kept, "", "") if len(kept) else None


def _curled(vertices: np.ndarray, faces: np.ndarray, at_border: np.ndarray) -> np.ndarray:
    """(F,) bool, of these faces; at_border: (V,) bool."""
    is_rim = at_border[faces].any(axis=1)
    a, b, c = vertices[faces].astype(np.float64).transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)  # as long as twice the area
    behind = _sums(faces, np.where(is_rim[:, None], 0.0, normals)[:, None], len(vertices))
    # A vertex of the border has no inner face, but neighbors that have some.
    corners = behind[faces]
    spread = _sums(faces, corners.sum(axis=1, keepdims=True) - corners, len(vertices)) + behind
    wanted = spread[faces].sum(axis=1)
    along = np.einsum("fk,fk->f", wanted, normals)
    lengths = np.linalg.norm(wanted, axis=1) * np.linalg.norm(normals, axis=1)
    found: np.ndarray = is_rim & (lengths > 0) & (along < _CURLED * lengths)
    return found


def _sums(faces: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """(count, 3): for each vertex the sum of what its faces give it, (F, 3 or 1 corners, 3)."""
    given = np.broadcast_to(values, (len(faces), 3, 3))
    return np.stack(
        [np.bincount(faces.ravel(), given[:, :, k].ravel(), count) for k in range(3)], axis=1
    )
