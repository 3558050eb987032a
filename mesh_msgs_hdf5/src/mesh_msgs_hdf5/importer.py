"""Reads a mesh from any known format: PLY, OBJ, STL, DAE (COLLADA), and map files themselves.
"""
import os
from typing import Tuple

from mesh_msgs_hdf5.check import checked_mesh
from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.formats.import_dae import read_dae
from mesh_msgs_hdf5.formats.import_obj import read_obj
from mesh_msgs_hdf5.formats.import_ply import read_ply
from mesh_msgs_hdf5.formats.import_stl import read_stl
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.mesh import Mesh
from mesh_msgs_hdf5.probe import kind_of, read_file, read_head
from mesh_msgs_hdf5.report import ImportReport

_READERS = {"ply": read_ply, "obj": read_obj, "stl": read_stl}
_NAMES = {"ply": "PLY", "obj": "OBJ", "stl": "STL", "dae": "DAE", "h5": "HDF5"}


def read_mesh(path: PathLike, part: str = "mesh") -> Tuple[Mesh, ImportReport]:
    """The mesh of a .ply, .obj, .stl, .dae or .h5 file and what reading it changed.

    The content decides where it can, else the suffix. PLY and OBJ keep the order and number of
    vertices; STL and DAE are welded. part: which mesh of a map file. Every face index and
    coordinate is checked. Raises MapFileError.
    """
    path = os.fsdecode(path)
    kind = kind_of(path, read_head(path))
    if not kind:
        raise MapFileError(
            "format",
            path,
            "its content is no mesh that is known, nor is its suffix",
            "known: .ply .obj .stl .dae .h5",
        )
    report = ImportReport(path, _NAMES[kind])
    try:
        if kind == "h5":
            mesh = _from_map(path, part, report)
        elif kind == "dae":
            mesh = read_dae(path, report)
        else:
            mesh = _READERS[kind](path, read_file(path), report)
    except MemoryError as error:
        raise MapFileError("size", path, "there is not enough memory to read it", "") from error
    if kind != "h5":  # a map file is checked while it is read
        mesh.source = {"file": os.path.basename(path), "format": report.format}
        if report.notes:
            mesh.source["notes"] = list(report.notes)
        mesh = checked_mesh(path, mesh)
    report.vertices, report.faces = len(mesh.vertices), len(mesh.faces)
    return mesh, report


def _from_map(path, part, report):
    file = MapFile(path, part)
    mesh = file.read()
    others = file.other_contents()
    if others:
        shown = ", ".join(others[:5]) + (", ..." if len(others) > 5 else "")
        report.note("left out: %d other objects of the file (%s)", len(others), shown)
    return mesh
