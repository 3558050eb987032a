"""Writes a mesh in a format of other programs: PLY, OBJ, STL, COLLADA, glTF."""
import contextlib
import os
from dataclasses import replace
from typing import Callable, Dict, List, Optional

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.checks.check import checked_mesh
from mesh_msgs_hdf5.files.save import check_target, save_file
from mesh_msgs_hdf5.formats.base.export_parts import Export
from mesh_msgs_hdf5.formats.dae.export_dae import dae_of
from mesh_msgs_hdf5.formats.gltf.export_glb import glb_of, gltf_of
from mesh_msgs_hdf5.formats.obj.export_obj import obj_of
from mesh_msgs_hdf5.formats.ply.export_ply import ply_of
from mesh_msgs_hdf5.formats.side_files import check_side_files
from mesh_msgs_hdf5.formats.stl import stl_of
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.rendering.render_scale import RAINBOW, finite_limits, value_colors

# how names end -> what makes the file and those beside it
WRITERS: Dict[str, Callable[[PathLike, Mesh], Export]] = {
    ".ply": ply_of,
    ".obj": obj_of,
    ".stl": stl_of,
    ".dae": dae_of,
    ".glb": glb_of,
    ".gltf": gltf_of,
}


# those whose numbers are exact in the coordinates of a country
GEOREFERENCED = (".ply", ".obj")


def check_georeferenced(path: PathLike) -> None:
    """Refuse formats whose coordinates are float32. Raises MapFileError."""
    suffix = os.path.splitext(os.fsdecode(path))[1].lower()
    if suffix not in GEOREFERENCED:
        raise MapFileError(
            "format",
            path,
            "%s holds float32 coordinates: georeferenced ones would be rounded"
            % suffix[1:].upper(),
            "name it %s, or leave --georeferenced out" % " or ".join(GEOREFERENCED),
        )


def write_mesh(
    path: PathLike,
    mesh: Mesh,
    overwrite: bool = False,
    layer: Optional[str] = None,
    georeferenced: bool = False,
) -> List[str]:
    """Write a mesh in the format that the path ends with; returns notes of what it cannot take.

    layer: the name of a layer that is painted into the vertex colors; georeferenced: coordinates
    with the origin added, as float64 (PLY, OBJ). OBJ and PLY name files beside
    them (textures, materials), which are written first; each takes its place in one step. Nothing
    is written if one of them exists and overwrite is False, or is not of the file that is
    overwritten. Raises MapFileError.
    """
    path = os.fsdecode(path)
    suffix = os.path.splitext(path)[1].lower()
    if suffix not in WRITERS:
        raise MapFileError(
            "format",
            path,
            "a mesh cannot be written as %s" % (one_line(suffix) or "a file without suffix"),
            "name it %s" % " ".join(WRITERS),
        )
    if georeferenced:
        check_georeferenced(path)
    check_target(path, overwrite)
    mesh = checked_mesh(path, mesh)
    notes: List[str] = []
    if georeferenced:
        mesh = _georeferenced(mesh, notes)
    if layer is not None:
        mesh = _painted(path, mesh, layer, notes)
    export = WRITERS[suffix](path, mesh)
    folder = os.path.dirname(os.path.realpath(path))
    beside = {os.path.join(folder, name): data for name, data in export.beside.items()}
    beside = {name: data for name, data in beside.items() if not _holds(name, data)}
    check_side_files(path, map(os.path.basename, beside))
    for name in beside:
        check_target(name, overwrite)
    new: List[str] = []
    try:
        for name, data in beside.items():
            is_new = not os.path.exists(name)
            save_file(name, data, overwrite=overwrite)
            new += [name] if is_new else []
        save_file(path, export.content, overwrite=overwrite)
    except BaseException:  # also an interrupt: nothing names the new files
        for name in new:
            with contextlib.suppress(OSError):
                os.unlink(name)
        raise
    notes += export.notes
    if any(mesh.origin) and suffix not in (
        ".stl",
        ".dae",
    ):  # where the origin is left out, which is said already
        hint = "; --georeferenced adds it" if suffix in GEOREFERENCED else ""
        text = "coordinates are without the origin %s, %s, %s"
        notes.append(text % tuple(mesh.origin) + hint)
    return notes


def _georeferenced(mesh: Mesh, notes: List[str]) -> Mesh:
    """The mesh with float64 vertices in its reference system, and no origin."""
    text = "coordinates are those of %s, with the origin %s, %s, %s"
    where = one_line(mesh.crs) or "the reference system (which the map does not name)"
    notes.append(text % (where, *mesh.origin))
    vertices = mesh.vertices.astype(np.float64) + np.array(mesh.origin, np.float64)
    return replace(mesh, vertices=vertices, origin=(0.0, 0.0, 0.0))


def _holds(name: str, data: bytes) -> bool:
    """True if the file is there already, as for a second format of the same textures."""
    try:
        if not os.path.isfile(name) or os.stat(name).st_size != len(data):
            return False
        with open(name, "rb") as stream:
            return stream.read() == data
    except OSError:
        return False


def _painted(path: str, mesh: Mesh, layer: str, notes: List[str]) -> Mesh:
    """The mesh in the colors of a layer, as RViz has them; materials would hide them."""
    if layer not in mesh.vertex_costs:
        known = ", ".join(sorted(mesh.vertex_costs)) or "none"
        raise MapFileError(
            "layer",
            path,
            "there is no layer %s to paint" % one_line(layer)[:80],
            "layers: %s" % one_line(known),
        )
    costs = mesh.vertex_costs[layer]
    colors = np.rint(255 * value_colors(RAINBOW, finite_limits(costs), costs)).astype(np.uint8)
    if mesh.vertex_colors is not None:
        notes.append("the vertex colors are those of layer %s, not of the mesh" % layer)
    if mesh.materials is not None or mesh.textures:
        notes.append("left out: materials and textures, which would hide the colors of the layer")
    return replace(
        mesh, vertex_colors=colors, materials=None, textures={}, texture_coordinates=None
    )
