"""COLLADA, FBX and 3DS to Mesh, through assimp; vertices at exactly one position become one."""
import os
import re
from functools import partial
from typing import List, Optional, Tuple

import numpy as np

from mesh_msgs_hdf5.formats.base.beside import Folder, shown
from mesh_msgs_hdf5.formats.base.material_list import NO_TEXTURE, ImportedTextures, give_materials
from mesh_msgs_hdf5.formats.base.options import Options
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.scene import Scene, welded_mesh, z_up
from mesh_msgs_hdf5.formats.dae.assimp import Material
from mesh_msgs_hdf5.formats.dae.fbx_settings import unit, up_axis
from mesh_msgs_hdf5.formats.dae.own_materials import own_materials
from mesh_msgs_hdf5.formats.dae.zae_archive import image_in
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_NAMES = {"dae": "COLLADA", "zae": "COLLADA", "fbx": "FBX", "3ds": "3DS"}
_INSIDE = re.compile(r"\*(\d{1,9})")


def mesh_of_scene(
    path: PathLike,
    kind: str,
    data: bytes,
    scene: Scene,
    materials: List[Material],
    images: List[np.ndarray],
    options: Options,
    report: ImportReport,
) -> Mesh:
    """A Mesh of what assimp.read_scene says of a file, in meters and z up (REP 103).

    kind: "dae", "zae", "fbx" or "3ds"; data: the bytes of the file; images: those in it.
    assimp applies COLLADA's unit and turns its up axis to y, and that of 3DS, which is z; the turn
    to z up here undoes that for a Z_UP file and makes (x, -z, y) of a Y_UP file's (x, y, z). Of FBX
    it applies neither. Its own reading of decimal numbers is exact to the last bit but one.
    """
    if not len(scene.faces):
        name = _NAMES[kind]
        raise MapFileError(
            "no_faces",
            path,
            "the %s file has no faces in its scene" % name,
            "a map needs triangles: mesh the points first",
        )
    up = up_axis(data) if kind == "fbx" else "y"
    if up != "z":
        scene.positions, scene.normals = z_up(scene.positions), z_up(scene.normals)
    if kind == "fbx":
        meters = unit(data)
        scene.positions = scene.positions * meters
        report.note("FBX's unit (%g m) and up axis (%s) were applied: meters, z up", meters, up)
        if up == "x":
            report.note("its x axis is up, which was taken for y; --transform turns it")
    elif kind == "3ds":
        report.note("3DS says no unit: meters were taken; --scale is for others")
    else:
        report.note("COLLADA's unit and up axis were applied: meters, z up")
    mesh = welded_mesh(path, scene, options, report)
    textures = ImportedTextures(Folder(path), report, wanted=mesh.texture_coordinates is not None)
    if kind == "dae":
        names = [material["name"] for material in materials]
        own = own_materials(data, names, scene.face_materials, textures, report)
        if own is not None:
            give_materials(mesh, own.materials, own.faces, textures, exact=True)
            return mesh
    used, numbers = np.unique(scene.face_materials, return_inverse=True)
    found = []
    for material in (materials[number] for number in used.tolist()):
        name = material["texture"]
        inside = _INSIDE.fullmatch(name or "")
        if inside and int(inside[1]) < len(images):
            image = images[int(inside[1])].tobytes()
            reason = "is not compressed, which is not read"
            read = partial(_given, image, reason)
            index = textures.add(("inside", inside[1]), "texture %s of the file" % name, read)
        elif name is not None and kind == "zae":
            read = partial(image_in, data, name)
            index = textures.add(("archive", name), "texture %s" % shown(name), read)
        else:
            index = NO_TEXTURE if name is None else textures.add_file(os.fsencode(name))
        found.append((tuple(material["color"]), index))
    give_materials(mesh, found, numbers, textures)
    return mesh


def _given(data: bytes, reason: str) -> Tuple[Optional[bytes], str]:
    return (data, "") if data else (None, reason)
