"""Meshes with copies along the seams of textures, in OBJ: one v line for each point.

OBJ has texture coordinates for corners of faces, so other programs get the surface uncut. A vt line
of our export stands for each vertex of the mesh, in its order; a remark says so: {"seams": C}.
"""
from typing import List, Optional

import numpy as np

from mesh_msgs_hdf5.formats.base.polygons import Triangles
from mesh_msgs_hdf5.formats.base.remap import take_vertices
from mesh_msgs_hdf5.formats.base.remarks import Remark, about
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.values import coordinates_or_none
from mesh_msgs_hdf5.model.mesh import Mesh

_KEY = "seams"


def is_one_line_enough(mesh: Mesh) -> bool:
    """Whether all that a v line has is the same for copies and their originals, and a corner of a
    face tells of which vertex each copy is one."""
    originals, colors = mesh.seam_originals, mesh.vertex_colors
    if originals is None or mesh.texture_coordinates is None:
        return False
    count = len(mesh.vertices) - len(originals)
    if colors is not None and (colors[count:] != colors[originals]).any():
        return False
    used = np.zeros(len(mesh.vertices), bool)
    used[mesh.faces] = True
    return bool(used[count:].all())


def seams_remark(mesh: Mesh) -> Remark:
    """Says that the vt lines are the vertices of the mesh."""
    return {_KEY: len(mesh.vertices) - len(mesh.parent_vertices)}


def remarked_originals(
    remarks: List[Remark], corners: np.ndarray, index: np.ndarray, vertex_count: int, rows: int
) -> Optional[np.ndarray]:
    """(C,) of which vertices the vt lines behind the first ones are copies; None where no remark
    says so, or that is not so.

    corners, index: (N,) the v and vt line of each corner; vertex_count, rows: how many there are.
    """
    found = about(remarks, _KEY, int)
    if not found or found[0][_KEY] < 1 or rows != vertex_count + found[0][_KEY]:
        return None
    original = np.full(rows, -1, np.int64)
    original[:vertex_count] = np.arange(vertex_count)
    original[index] = corners
    sound = (index >= 0).all() and (original >= 0).all() and (original[index] == corners).all()
    sound = sound and np.array_equal(original[:vertex_count], np.arange(vertex_count))
    return original[vertex_count:] if sound else None


def with_copies(
    mesh: Mesh,
    originals: np.ndarray,
    coordinates: np.ndarray,
    triangles: Triangles,
    index: np.ndarray,
    report: ImportReport,
) -> Mesh:
    """The mesh, without normals, with these copies and coordinates (V + C, 2)."""
    mesh = take_vertices(mesh, np.append(np.arange(len(mesh.vertices)), originals))
    mesh.faces = triangles.of_corners(index).astype(np.uint32).reshape(-1, 3)
    mesh.texture_coordinates = coordinates_or_none(coordinates, mesh.faces, report)
    mesh.seam_originals = originals.astype(np.uint32)
    return mesh
