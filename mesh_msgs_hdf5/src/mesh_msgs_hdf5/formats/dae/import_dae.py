"""COLLADA to Mesh, through assimp; vertices at exactly the same position become one."""
import os
from typing import List

import numpy as np

from mesh_msgs_hdf5.formats.base.beside import Folder
from mesh_msgs_hdf5.formats.base.material_list import NO_TEXTURE, ImportedTextures, give_materials
from mesh_msgs_hdf5.formats.base.options import Options
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.scene import Scene, welded_mesh, z_up
from mesh_msgs_hdf5.formats.dae.assimp import Material
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh


def mesh_of_scene(
    path: PathLike, scene: Scene, materials: List[Material], options: Options, report: ImportReport
) -> Mesh:
    """A Mesh of what assimp.read_scene says of a COLLADA file, in meters and z up (REP 103).

    assimp applies the file's unit and turns its up axis to y; the turn to z up here undoes that for
    a Z_UP file and makes (x, -z, y) of a Y_UP file's (x, y, z). assimp's own reading of decimal
    numbers is exact to the last bit but one.
    """
    if not len(scene.faces):
        raise MapFileError("no_faces", path, "the COLLADA file has no faces in its scene", "")
    scene.positions, scene.normals = z_up(scene.positions), z_up(scene.normals)
    report.note("COLLADA's unit and up axis were applied: meters, z up")
    mesh = welded_mesh(path, scene, options, report)
    textures = ImportedTextures(Folder(path), report, wanted=mesh.texture_coordinates is not None)
    used, numbers = np.unique(scene.face_materials, return_inverse=True)
    found = []
    for material in (materials[number] for number in used.tolist()):
        name = material["texture"]
        index = NO_TEXTURE if name is None else textures.add_file(os.fsencode(name))
        found.append((tuple(material["color"]), index))
    give_materials(mesh, found, numbers, textures)
    return mesh
