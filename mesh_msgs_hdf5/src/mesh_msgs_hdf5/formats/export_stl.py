"""Mesh to STL (binary): triangles and nothing else."""
import numpy as np

from mesh_msgs_hdf5.errors import PathLike
from mesh_msgs_hdf5.formats.export_parts import Export, check_size
from mesh_msgs_hdf5.formats.import_stl import TRIANGLE
from mesh_msgs_hdf5.mesh import Mesh

_EVERYTHING = (
    "vertex_normals",
    "vertex_colors",
    "vertex_costs",
    "face_attributes",
    "texture_coordinates",
    "textures",
    "materials",
    "labels",
    "features",
    "origin",
    "crs",
)


def stl_of(path: PathLike, mesh: Mesh) -> Export:
    """The STL file; the normal of a triangle without area is 0 0 0."""
    export = Export()
    rows = np.zeros(len(mesh.faces), TRIANGLE)
    rows["corners"] = mesh.vertices[mesh.faces]
    corners = rows["corners"].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    rows["normal"] = normals / np.where(length > 0, length, 1)
    # the head must not begin like that of a text file: solid
    head = b"binary STL of mesh_msgs_hdf5".ljust(80)
    check_size(path, rows.nbytes, "STL")
    export.content = head + len(rows).to_bytes(4, "little") + rows.tobytes()
    export.leave_out(mesh, "STL", *_EVERYTHING)
    export.note("STL has no vertices of its own: reading it welds corners at the same position")
    return export
