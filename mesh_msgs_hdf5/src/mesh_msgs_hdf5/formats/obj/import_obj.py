"""Wavefront OBJ to Mesh: vertex order and count are kept.

Read: v (with colors behind the position), vn, vt, f (v, v/vt, v//vn, v/vt/vn, negative numbers,
polygons), mtllib, usemtl; g where our export has written labels as groups; g, o or usemtl as labels
where that is asked for.
"""
from typing import List

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.base.beside import Folder
from mesh_msgs_hdf5.formats.base.corners import agreed, note_missing, with_corner_coordinates
from mesh_msgs_hdf5.formats.base.material_list import ImportedTextures, give_materials
from mesh_msgs_hdf5.formats.base.options import Options, placed
from mesh_msgs_hdf5.formats.base.polygons import (
    Triangles,
    check_corners,
    polygon_edges,
    triangulate,
)
from mesh_msgs_hdf5.formats.base.remarks import (
    Remark,
    about,
    parsed_remarks,
    remarked_origin,
    take_mesh_remark,
)
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.values import colors_or_none, coordinates_or_none, normals_or_none
from mesh_msgs_hdf5.formats.obj.obj_groups import take_groups
from mesh_msgs_hdf5.formats.obj.obj_lines import from_zero, read_lines
from mesh_msgs_hdf5.formats.obj.obj_materials import face_materials, read_mtl_files
from mesh_msgs_hdf5.formats.obj.obj_seams import remarked_originals, with_copies
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_MEANING = {b"l": "lines", b"p": "points"}


def read_obj(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    """A Mesh of an OBJ file's bytes; materials and textures are read from its folder."""
    lines = read_lines(path, data)
    if not lines.vertices.rows:
        raise MapFileError(
            "format", path, "the OBJ file has no vertices (v lines)", "is it a mesh?"
        )
    remarks = parsed_remarks(lines.remarks, report)
    positions, colors = _vertices(path, lines, report)
    if not lines.faces.rows:
        raise MapFileError(
            "no_faces",
            path,
            "the OBJ file has no faces (f lines)",
            "a map needs triangles: mesh the points first",
        )
    written, counts = lines.faces.joined()
    if lines.before:
        last = np.repeat(np.concatenate(lines.before), counts, axis=0)
    else:  # no number is negative: it is not asked for
        last = np.broadcast_to(0, written.shape)
    corners = from_zero(written[:, 0], last[:, 0])
    check_corners(path, counts, corners, len(positions), shown=written[:, 0])
    vertices, origin = placed(
        path,
        positions,
        "vertex",
        options,
        report,
        remarked_origin(remarks),
        lambda: polygon_edges(counts, corners),
    )
    triangles = triangulate(counts, corners, positions, report)
    mesh = Mesh(vertices, triangles.faces, vertex_colors=colors, origin=origin)
    take_mesh_remark(path, mesh, remarks, report)
    originals, of_vertices, count = None, corners, len(vertices)
    if lines.coordinates.rows:
        index = _checked(
            path, written[:, 1], last[:, 1], lines.coordinates.rows, "texture coordinates"
        )
        if options.split_seams is not False:
            rows = lines.coordinates.rows
            originals = remarked_originals(remarks, corners, index, count, rows)
    if originals is not None:
        of_vertices, count = index, lines.coordinates.rows
    normals = None
    if lines.normals.rows:
        of_normals = _checked(path, written[:, 2], last[:, 2], lines.normals.rows, "normal")
        normals = _normals(path, lines, of_vertices, of_normals, count, report)
    if originals is not None:
        table = _coordinate_table(path, lines)
        mesh = with_copies(mesh, originals, table, triangles, index, report)
        mesh.vertex_normals = normals
    else:
        mesh.vertex_normals = normals
        if lines.coordinates.rows:
            mesh = _with_coordinates(path, lines, mesh, triangles, corners, index, options, report)
    _take_materials(path, lines, mesh, triangles, remarks, report)
    take_groups(path, lines, mesh, triangles, remarks, options, report)
    for key, count in sorted(lines.others.items()):
        name = one_line(key.decode("latin-1"))[:40]
        report.note("left out: %s (%d %s lines)", _MEANING.get(key, "what is unknown"), count, name)
    return mesh


def _vertices(path, lines, report):
    """(V, 3) float64 positions and (V, 3) uint8 colors or None."""
    values, counts = lines.vertices.joined()
    wrong = np.flatnonzero((counts < 3) | (counts == 5) | (counts > 7))
    if len(wrong):
        raise MapFileError(
            "format",
            path,
            "vertex %d has %d values, not 3 (position), 4, 6 (with color) or 7"
            % (wrong[0], counts[wrong[0]]),
            "is the file damaged?",
        )
    table = _rows(values, counts)
    positions = table[:, :3]
    if (counts == 4).any():
        report.note("left out: the weight of %d vertices", np.count_nonzero(counts == 4))
    if (counts < 6).any():
        if (counts >= 6).any():
            report.note("colors left out: only %d vertices have one", np.count_nonzero(counts >= 6))
        return positions, None
    if (counts == 7).any():
        report.note("left out: the alpha of the vertex colors")
    colors = table[:, 3:6]
    whole = colors.max() > 1 and (colors == np.rint(colors)).all()  # some programs write bytes
    return positions, colors_or_none(colors, {"u1"} if whole else {"f8"}, report)


def _rows(values, counts):
    """(N, C) of lines of C numbers, or of at most C: then 0 stands in for what is missing."""
    width = int(counts.max())
    if (counts == width).all():
        return values.reshape(-1, width)
    table = np.zeros((len(counts), width))
    table[np.arange(width) < counts[:, None]] = values
    return table


def _checked(path, written, last, count, what):
    """The indices (N,) of what corners refer to; -1 for none."""
    index = from_zero(written, last)
    wrong = np.flatnonzero((written != 0) & ((index < 0) | (index >= count)))
    if len(wrong):
        raise MapFileError(
            "index",
            path,
            "a face refers to %s %d, but the file has %d; %d corners do so"
            % (what, written[wrong[0]], count, len(wrong)),
            "repair the mesh where it was made",
        )
    return index


def _is_own(corners, index, rows, vertex_count):
    """True if each vertex has the value of its own number."""
    return rows == vertex_count and bool(((index == corners) | (index < 0)).all())


def _normals(path, lines, corners, index, vertex_count, report):
    """(V, 3) float32 normals if every corner of a vertex has the same one, else None and a note."""
    values, counts = lines.normals.joined()
    if not (counts == 3).all():
        raise MapFileError(
            "format", path, "a normal (vn line) has not three values", "is the file damaged?"
        )
    normals = values.reshape(-1, 3)
    missing = np.count_nonzero(index < 0)
    if missing:
        report.note("normals left out: %d face corners have none", missing)
        return None
    if _is_own(corners, index, len(normals), vertex_count):
        return normals_or_none(normals, report)
    result = agreed(corners, normals[index], vertex_count)
    if result is None:
        report.note("normals left out: a vertex has different ones in different faces")
        return None
    return normals_or_none(result, report)


def _coordinate_table(path, lines):
    """(N, 2) float64 of the vt lines."""
    values, counts = lines.coordinates.joined()
    if (counts > 3).any():
        raise MapFileError(
            "format", path, "a texture coordinate (vt line) has four values", "is the file damaged?"
        )
    table = np.zeros((len(counts), 2))
    width = min(int(counts.max()), 2)
    table[:, :width] = _rows(values, counts)[:, :width]
    return table


def _with_coordinates(path, lines, mesh, triangles, corners, index, options, report):
    """The mesh with texture coordinates; with copies of vertices along seams, if they may be."""
    table = _coordinate_table(path, lines)
    if _is_own(corners, index, len(table), len(mesh.vertices)):
        note_missing(np.count_nonzero(index < 0), report)
        mesh.texture_coordinates = coordinates_or_none(table, mesh.faces, report)
        return mesh
    with np.errstate(over="ignore"):
        found = table.astype(np.float32)[np.maximum(index, 0)]
    split = options.split_seams is not False
    return with_corner_coordinates(mesh, triangles, found, index >= 0, split, report)


def _take_materials(path, lines, mesh, triangles: Triangles, remarks: List[Remark], report):
    uses = [(face, text) for face, key, text in lines.names if key == b"usemtl"]
    files = [text for _, key, text in lines.names if key == b"mtllib"]
    own = about(remarks, "materials", int)
    if not uses and not files and not own:
        return
    folder = Folder(path)
    textures = ImportedTextures(
        folder, report, wanted=mesh.texture_coordinates is not None or bool(own)
    )
    for remark in about(remarks, "texture", int):
        if isinstance(remark.get("file"), str) and 0 <= remark["texture"] < 1 << 31:
            textures.add_file(remark["file"], wanted=remark["texture"])
    known = read_mtl_files(folder, files, report)
    found = face_materials(uses, lines.faces.rows, known, textures, bool(own), report)
    give_materials(
        mesh, found.materials, triangles.of_polygons(found.polygons), textures, exact=bool(own)
    )
