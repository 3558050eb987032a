"""Reads a mesh from any known format: PLY, OBJ, STL, OFF, COLLADA, FBX, 3DS, glTF, and map files.
"""
import datetime
import hashlib
import os
import types
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

import numpy as np
from mesh_msgs.checks.rounding import is_too_much
from mesh_msgs.text import one_line

from mesh_msgs_hdf5 import __version__
from mesh_msgs_hdf5.checks.check import checked_mesh
from mesh_msgs_hdf5.files.probe import kind_of, read_file, read_head
from mesh_msgs_hdf5.formats.base.corners import note_seams
from mesh_msgs_hdf5.formats.base.foreign_labels import (
    ClassNames,
    note_numbered_labels,
    take_numbered_labels,
)
from mesh_msgs_hdf5.formats.base.movement import move_rest
from mesh_msgs_hdf5.formats.base.options import Options, checked_options, placed, told_up
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.merge import merge_vertices
from mesh_msgs_hdf5.formats.repair import repair
from mesh_msgs_hdf5.formats.stated_axes import stated_up
from mesh_msgs_hdf5.isolation import IsolatedMapFile, isolated
from mesh_msgs_hdf5.model.carried_mesh import mark_silent
from mesh_msgs_hdf5.model.edit import changed_labels
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from mesh_msgs_hdf5.model.seams import differing_copies, without_copies


# Each format is imported when the first file of it is read: nodes read map files, and start sooner.
def _read_ply(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    from mesh_msgs_hdf5.formats.ply.import_ply import read_ply

    return read_ply(path, data, options, report)


def _read_obj(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    from mesh_msgs_hdf5.formats.obj.import_obj import read_obj

    return read_obj(path, data, options, report)


def _read_stl(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    from mesh_msgs_hdf5.formats.stl import read_stl

    return read_stl(path, data, options, report)


def _read_off(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    from mesh_msgs_hdf5.formats.off import read_off

    return read_off(path, data, options, report)


def _read_gltf(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    from mesh_msgs_hdf5.formats.gltf.import_gltf import read_gltf

    return read_gltf(path, data, options, report)


def _read_dae(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    return _read_scene("dae", path, data, options, report)


def _read_zae(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    return _read_scene("zae", path, data, options, report)


def _read_fbx(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    return _read_scene("fbx", path, data, options, report)


def _read_3ds(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    return _read_scene("3ds", path, data, options, report)


def _read_scene(
    kind: str, path: PathLike, data: bytes, options: Options, report: ImportReport
) -> Mesh:
    """assimp reads the file itself, and may crash over it: in a process of its own."""
    from mesh_msgs_hdf5.formats.base.scene import Scene
    from mesh_msgs_hdf5.formats.dae.import_dae import mesh_of_scene

    try:
        scene, materials, images, notes = isolated(
            "collada",
            path,
            memory_limit=_DAE_MEMORY + _DAE_MEMORY_PER_BYTE * len(data),
            timeout=DAE_SECONDS + _DAE_SECONDS_PER_BYTE * len(data),
            library="assimp",
        )
    except MapFileError as error:
        if error.code not in _DAE_CODES:
            raise
        hint = "convert it to PLY or OBJ where it was made"
        raise MapFileError(_DAE_CODES[error.code], path, error.message, hint) from error
    report.notes += notes
    given = Scene(**scene), materials, images
    return mesh_of_scene(path, kind, data, *given, options, report)


Read = Callable[[PathLike, bytes, Options, ImportReport], Mesh]
# suffix, as probe.kind_of says it -> (name in reports, what reads it); a map file is none of these
FORMATS: Dict[str, Tuple[str, Read]] = {
    "ply": ("PLY", _read_ply),
    "obj": ("OBJ", _read_obj),
    "stl": ("STL", _read_stl),
    "off": ("OFF", _read_off),
    "dae": ("DAE", _read_dae),
    "zae": ("ZAE", _read_zae),
    "fbx": ("FBX", _read_fbx),
    "3ds": ("3DS", _read_3ds),
    "glb": ("GLB", _read_gltf),
    "gltf": ("glTF", _read_gltf),
}
MAP_SUFFIXES = (".h5", ".hdf5")
# what reading through assimp may take: for any file, and for each byte of it
DAE_SECONDS, _DAE_SECONDS_PER_BYTE = 60, 5e-6
_DAE_MEMORY, _DAE_MEMORY_PER_BYTE = 2 << 30, 100
_DAE_CODES = {"crashed": "damaged", "timeout": "size"}


def import_suffixes() -> Tuple[str, ...]:
    """What names of files that can be read end with."""
    return tuple("." + suffix for suffix in FORMATS) + MAP_SUFFIXES


def read_mesh(
    path: PathLike,
    part: Optional[str] = None,
    label_changes: Mapping[str, Optional[Label]] = types.MappingProxyType({}),
    **options: Any,
) -> Tuple[Mesh, ImportReport]:
    """The mesh of a file of a known format, and what reading it changed.

    The content decides where it can, else the suffix. PLY, OBJ and OFF keep the order and number of
    vertices; the others are welded, except for glTF that this package wrote. part: which
    mesh of a map file. label_changes: of its labels, as in an Edit (labels.map_contents.read_map
    has those of the journal). options: origin, split_seams, merge_vertices, repair, up,
    scale, transform, labels_from, label_names, label_texts, label_colors, see formats.base.options.
    Every face index and coordinate is checked. Raises MapFileError.
    """
    path = os.fsdecode(path)
    chosen = checked_options(path, **options)
    kind = kind_of(path, read_head(path))
    if not kind:
        raise MapFileError(
            "format",
            path,
            "its content is no mesh that is known, nor is its suffix",
            "known: %s" % " ".join(import_suffixes()),
        )
    report = ImportReport(path, "HDF5" if kind == "h5" else FORMATS[kind][0])
    try:
        if kind == "h5":
            mesh = _from_map(path, part, label_changes, chosen, report)
        else:
            mesh = _from_format(path, kind, chosen, report)
    except MemoryError as error:
        raise MapFileError(
            "size",
            path,
            "there is not enough memory to read it",
            "export a part of it, or use a machine with more",
        ) from error
    report.count(mesh)
    return mesh, report


def read_unharmed_mesh(
    path: PathLike, split_seams: Optional[bool] = None
) -> Tuple[Mesh, ImportReport]:
    """read_mesh(path), for those who cannot ask for an origin.

    Raises MapFileError (rounded: float32 would change its coordinates too much; what it raises).
    """
    mesh, report = read_mesh(path, split_seams=split_seams)
    if is_too_much(report.rounded, mesh.vertices):
        raise too_much_rounded(path, report.rounded)
    return mesh, report


def too_much_rounded(path: PathLike, change: float) -> MapFileError:
    """The error of coordinates that float32 would change so much (meters)."""
    return MapFileError(
        "rounded",
        path,
        "float32 would change its coordinates by up to %.3g m" % change,
        "make a map file near an origin: "
        "rosrun mesh_msgs_hdf5 mesh_tool import IN OUT.h5 --origin auto",
    )


def _from_format(path, kind, options, report):
    data = read_file(path)
    options = told_up(path, options, stated_up(kind, data), report.format)
    mesh = _seamed(FORMATS[kind][1](path, data, options, report), options, report)
    if options.matrix is not None:
        move_rest(mesh, options.matrix, mesh.origin, report)
    if options.labels_from and kind != "obj":  # whose groups its reader knows
        _take_labels(path, mesh, options, report)
    if not options.labels_from:
        note_numbered_labels(mesh, report)
    mesh = _mended(path, mesh, options, report)
    mesh.source = _provenance(path, data, mesh.source, options, report)
    return checked_mesh(path, mesh)


def _take_labels(path, mesh, options, report):
    names = ClassNames(*map(dict, (options.label_names, options.label_texts, options.label_colors)))
    take_numbered_labels(path, mesh, options.labels_from, names, report)


def _seamed(mesh, options, report):
    """The mesh with its copies along seams, if they are wanted."""
    originals = mesh.seam_originals
    if originals is None:
        return mesh
    count = len(set(originals.tolist()))
    # the coordinates of our exports are left as they are
    alone = options.split_seams is None and report.split and not mesh.textures
    if alone or options.split_seams is False:
        note_seams(count, report)
        report.split = 0
        if mesh.textures:
            report.note("left out: %d textures, for want of coordinates", len(mesh.textures))
        _note_differing_copies(mesh, report)
        return without_copies(mesh)
    if report.split:
        text = "textures have seams at %d vertices: the last %d vertices are copies of them"
        report.note(text, count, len(originals))
    return mesh


def _note_differing_copies(mesh, report):
    differing = differing_copies(mesh)
    if differing:
        text = ["%d %s" % (n, one_line(what)) for what, n in list(differing.items())[:8]]
        text += ["..."] if len(differing) > 8 else []
        report.note(
            "copies along seams differ from their originals, whose values stay (of layers the "
            "largest): %s",
            ", ".join(text),
        )


def _mended(path, mesh, options, report):
    before = len(mesh.vertices), mesh.faces
    if options.merge_vertices is not None:
        mesh = merge_vertices(path, mesh, options.merge_vertices, report)
    mesh = repair(path, mesh, report) if options.repair else mesh
    if len(mesh.vertices) != before[0] or not np.array_equal(mesh.faces, before[1]):
        mark_silent(mesh, "import")
    return mesh


def _provenance(path, data, before, options, report):
    """Where the mesh comes from: the same file gives the same, at any time and place."""
    changed = datetime.datetime.fromtimestamp(int(os.stat(path).st_mtime), datetime.timezone.utc)
    source: Dict[str, Any] = {
        "file": os.path.basename(path),
        "format": report.format,
        "bytes": len(data),
        "sha256": hashlib.sha256(data).hexdigest(),
        "file_date": changed.isoformat(),
        "tool": "mesh_msgs_hdf5 " + __version__,
    }
    for name, value in (
        ("options", options.recorded()),
        ("notes", list(report.notes)),
        ("before", before),
    ):
        if value:
            source[name] = value
    return source


def _from_map(path, part, label_changes, options, report):
    with IsolatedMapFile(path, part) as file:  # it may come from anywhere
        mesh = file.read()
        others = file.other_contents()
        report.rounded = file.vertex_rounding
        report.notes += file.notes
    if label_changes:
        mesh.labels = changed_labels(mesh.labels, label_changes)
    if others:
        shown = ", ".join(others[:5]) + (", ..." if len(others) > 5 else "")
        report.note("left out: %d other objects of the file (%s)", len(others), shown)
    if not options.recorded():
        return mesh
    before = mesh.origin
    if "origin" in options.recorded() or options.matrix is not None:
        mesh.vertices, mesh.origin = placed(
            path, mesh.vertices, "vertex", options, report, tuple(mesh.origin)
        )
    if options.matrix is not None:
        move_rest(mesh, options.matrix, before, report)
    if options.labels_from:
        _take_labels(path, mesh, options, report)
    if options.split_seams is False:
        mesh = _seamed(mesh, options, report)
    # what was read is checked already; merging and repairing keep it sound
    mesh = _mended(path, mesh, options, report)
    mesh.source = dict(mesh.source, options=options.recorded())
    return checked_mesh(path, mesh)
