"""OFF (ASCII) to Mesh: vertex order and count are kept.

Format: Geomview's Object File Format, with the prefixes ST, C and N: texture coordinates, colors
and normals of the vertices, behind the position in the order normal, color, texture coordinates.
"""
import re
from typing import List, NamedTuple, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.base.numbers_text import numbers
from mesh_msgs_hdf5.formats.base.options import Options, placed
from mesh_msgs_hdf5.formats.base.polygons import (
    check_corners,
    polygon_edges,
    triangulate,
)
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.formats.base.values import (
    add_attribute,
    colors_or_none,
    coordinates_or_none,
    normals_or_none,
)
from mesh_msgs_hdf5.formats.ply.ply_faces import FACE_COLORS
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

# the counts may follow at once: OFF490 518 0
_HEAD = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF(?![A-Za-z])")
_COMMENT = re.compile(rb"#[^\n]*")


class _Head(NamedTuple):
    """Which values each vertex has behind its position."""

    normals: bool
    colors: bool
    coordinates: bool


def read_off(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    """A Mesh of an OFF file's bytes."""
    head, lines = _lines(path, data)
    (vertex_count, face_count), lines = _counts(path, lines)
    if len(lines) < vertex_count + face_count:
        raise MapFileError(
            "truncated",
            path,
            "the file is cut off: it announces %d vertices and %d faces, but holds %d lines of them"
            % (vertex_count, face_count, len(lines)),
            "copy or fetch it again",
        )
    if not face_count:
        raise MapFileError(
            "no_faces",
            path,
            "the OFF file has no faces",
            "a map needs triangles: mesh the points first",
        )
    table = _vertices(path, head, lines[:vertex_count])
    counts, corners, colors = _faces(path, lines[vertex_count : vertex_count + face_count])
    check_corners(path, counts, corners, vertex_count)
    positions = table[:, :3]
    vertices, origin = placed(
        path,
        positions,
        "vertex",
        options,
        report,
        edges=lambda: polygon_edges(counts, corners),
    )
    triangles = triangulate(counts, corners, positions, report)
    mesh = Mesh(vertices, triangles.faces, origin=origin)
    _take_vertex_values(mesh, head, table[:, 3:], report)
    if colors is not None:
        found = _colors(colors, "face", report)
        if found is not None:
            add_attribute(path, mesh, "face", FACE_COLORS, triangles.of_polygons(found), report)
    elif (_lengths(lines[vertex_count : vertex_count + face_count]) != counts + 1).any():
        report.note("left out: what stands behind the corners of faces and is no color of each")
    if len(lines) > vertex_count + face_count:
        left = len(lines) - vertex_count - face_count
        report.note("left out: %d lines after the last face", left)
    return mesh


def _lines(path, data) -> Tuple[_Head, List[bytes]]:
    """The head, and the lines behind it that are not empty, without comments."""
    if b"\0" in data:
        raise MapFileError("format", path, "binary OFF is not read", "save it as ASCII, or as PLY")
    text = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b"#" in text:
        text = _COMMENT.sub(b"", text)
    text = text.lstrip()
    found = _HEAD.match(text)
    if found is None:
        raise MapFileError("format", path, "the OFF file does not begin with OFF", "check the name")
    coordinates, colors, normals, four, many = (bool(group) for group in found.groups())
    if four or many:
        raise MapFileError(
            "format",
            path,
            "its vertices have not three dimensions (%s)" % found[0].decode(),
            "save it as OFF",
        )
    lines = [line for line in text[found.end() :].split(b"\n") if line and not line.isspace()]
    if lines and lines[0].split()[0].upper() == b"BINARY":
        raise MapFileError("format", path, "binary OFF is not read", "save it as ASCII, or as PLY")
    return _Head(normals, colors, coordinates), lines


def _counts(path, lines):
    """((vertices, faces), the lines behind them)."""
    words = lines[0].split() if lines else []
    try:
        vertices, faces = int(words[0]), int(words[1])
        if vertices < 0 or faces < 0:
            raise ValueError
    except (IndexError, ValueError) as error:
        raise MapFileError(
            "format",
            path,
            "the OFF file does not begin with its numbers of vertices and faces: %s"
            % one_line(repr(b" ".join(words)[:40])[1:]),
            "is the file damaged?",
        ) from error
    return (vertices, faces), lines[1:]


def _lengths(lines):
    """(N,) the number of words of each line."""
    return np.array([len(line.split()) for line in lines], np.int64)


def _numbers(path, lines, lengths, what):
    found = numbers(path, b" ".join(lines), what)
    if len(found) != lengths.sum():  # two in one word: 1.5.2
        raise MapFileError(
            "format", path, "%s: some words are no numbers" % what, "is the file damaged?"
        )
    return found


def _vertices(path, head, lines):
    """(V, C) float64: position, normal, color, texture coordinates."""
    lengths = _lengths(lines)
    least = 3 + 3 * head.normals + 3 * head.colors + 2 * head.coordinates
    known = {least, least + 1} if head.colors else {least}
    width = int(lengths[0]) if len(lengths) else least
    wrong = np.flatnonzero((lengths != width) | (width not in known))
    if len(wrong):
        raise MapFileError(
            "format",
            path,
            "vertex %d of the OFF file has %d values, not %s"
            % (wrong[0], lengths[wrong[0]], " or ".join(str(n) for n in sorted(known))),
            "is the file damaged, or its first line wrong?",
        )
    return _numbers(path, lines, lengths, "vertices").reshape(-1, width)


def _faces(path, lines):
    """(corners of each polygon (N,), the vertices of all, colors (N, C) float64 or None)."""
    lengths = _lengths(lines)
    flat = _numbers(path, lines, lengths, "faces")
    begins = np.cumsum(lengths) - lengths
    written = flat[begins]
    wrong = np.flatnonzero(~((written >= 0) & (written == np.floor(written))))
    wrong = wrong if len(wrong) else np.flatnonzero(written > lengths - 1)
    if len(wrong):
        raise MapFileError(
            "format",
            path,
            "face %d of the OFF file says that it has %g corners, but %d numbers follow"
            % (wrong[0], written[wrong[0]], lengths[wrong[0]] - 1),
            "is the file damaged?",
        )
    counts = written.astype(np.int64)
    first = np.repeat(begins + 1, counts)
    corners = flat[first + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)]
    wrong = np.flatnonzero(corners != np.floor(corners))
    if len(wrong):
        raise MapFileError(
            "index",
            path,
            "vertex index %s is no whole number" % corners[wrong[0]],
            "export the mesh again where it was made",
        )
    behind = lengths - 1 - counts
    colors = None
    if (behind == behind[0]).all() and behind[0] in (3, 4):
        colors = flat[(begins + 1 + counts)[:, None] + np.arange(3)]
    return counts, np.clip(corners, -1, 1 << 62).astype(np.int64), colors


def _take_vertex_values(mesh, head, table, report):
    at = 0
    if head.normals:
        mesh.vertex_normals = normals_or_none(table[:, :3], report)
        at = 3
    if head.colors:
        mesh.vertex_colors = _colors(table[:, at : at + 3], "vertex", report)
        alpha = table[:, at + 3 : table.shape[1] - 2 * head.coordinates]
        if alpha.size and not np.isin(alpha, (1, 255)).all():
            report.note("left out: the alpha of the vertex colors")
    if head.coordinates:
        mesh.texture_coordinates = coordinates_or_none(table[:, -2:], mesh.faces, report)


def _colors(values, place, report):
    """(N, 3) uint8 of whole numbers up to 255, or of floats up to 1; None with a note."""
    whole = values.max(initial=0) > 1 and (values == np.rint(values)).all()
    return colors_or_none(values, {"u1"} if whole else {"f8"}, report, place)
