"""COLLADA to Mesh, through assimp.

Corners at exactly the same position become one vertex, the report says so.
"""
import numpy as np

from mesh_msgs_hdf5.formats.assimp_child import corners_of_scene
from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.exact import narrowed
from mesh_msgs_hdf5.mesh import Mesh
from mesh_msgs_hdf5.formats.polygons import weld
from mesh_msgs_hdf5.report import ImportReport


def read_dae(path: PathLike, report: ImportReport) -> Mesh:
    """A Mesh of a COLLADA file, in meters and z up (REP 103).

    assimp applies the file's unit and turns its up axis to y; the turn to z up here undoes that for
    a Z_UP file and makes (x, -z, y) of a Y_UP file's (x, y, z). assimp's own reading of decimal
    numbers is exact to the last bit but one.
    """
    corners = corners_of_scene(path, report)
    if not len(corners):
        raise MapFileError("no_faces", path, "the COLLADA file has no faces in its scene", "")
    corners = np.stack([corners[:, 0], -corners[:, 2], corners[:, 1]], axis=1)
    corners, _ = narrowed(corners, path, "corner")
    report.note("COLLADA's unit and up axis were applied: meters, z up")
    vertices, index = weld(corners, report)
    return Mesh(vertices, index.reshape(-1, 3))
