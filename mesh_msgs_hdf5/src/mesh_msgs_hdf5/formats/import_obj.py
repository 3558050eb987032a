"""Wavefront OBJ to Mesh: vertex order and count are kept.

Read: v (with colors after the position), vn, f (v, v/vt, v//vn, v/vt/vn, negative numbers,
polygons).
"""
import re
from array import array

import numpy as np

from mesh_msgs_hdf5.errors import MapFileError, PathLike, one_line
from mesh_msgs_hdf5.exact import narrowed
from mesh_msgs_hdf5.formats.import_ply import colors_or_none, normals_or_none
from mesh_msgs_hdf5.mesh import Mesh
from mesh_msgs_hdf5.formats.numbers_text import numbers
from mesh_msgs_hdf5.formats.polygons import check_corners, triangulate
from mesh_msgs_hdf5.report import ImportReport, note_rounding

_BLOCK_BYTES = 8 << 20
_CONTINUED = re.compile(rb"\\[ \t]*(?:\r\n|\n|\r)")
_BYTE_ORDER_MARK = b"\xef\xbb\xbf"
_NORMAL_NUMBER = re.compile(rb"[^\s/]+/[^\s/]*/([^\s/]+)")
_SILENT = {b"o", b"g", b"s"}  # names and shading of groups: they change no value of the mesh
_MEANING = {
    b"vt": "texture coordinates",
    b"usemtl": "materials",
    b"mtllib": "material files",
    b"l": "lines",
    b"p": "points",
}


def read_obj(path: PathLike, data: bytes, report: ImportReport) -> Mesh:
    """A Mesh of an OBJ file's bytes."""
    lines = _Lines(data)
    if not len(lines.vertices.counts):
        raise MapFileError(
            "format", path, "the OBJ file has no vertices (v lines)", "is it a mesh?"
        )
    positions, colors = _vertices(path, lines.vertices, report)
    vertices, change = narrowed(positions, path, "vertex")
    note_rounding(report, change)
    if not len(lines.faces.counts):
        raise MapFileError(
            "no_faces",
            path,
            "the OBJ file has no faces (f lines)",
            "a map needs triangles: mesh the points first",
        )
    corners = _corners(path, lines, len(vertices))
    faces = triangulate(lines.faces.counts, corners, report)
    mesh = Mesh(vertices, faces, vertex_colors=colors)
    if len(lines.normals.counts):
        mesh.vertex_normals = _normals(path, lines, corners, len(vertices), report)
    for key, count in sorted(lines.others.items()):
        name = one_line(key.decode("latin-1"))[:40]
        report.note("left out: %s (%d %s lines)", _MEANING.get(key, "what is unknown"), count, name)
    return mesh


class _Texts:
    """What stands behind one keyword: a text for each block of the file, and words per line (N,).

    One text for a block and not for a line, which would take ten times the memory of the file.
    """

    def __init__(self):
        self.texts, self.counts = [], array("q")

    def take(self, lines):
        """Move the lines of a block here."""
        self.counts.extend([len(line.split()) for line in lines])
        self.texts.append(b" ".join(lines))
        lines.clear()


class _Lines:
    """The lines of the file by keyword, without it."""

    def __init__(self, data):
        self.vertices, self.normals, self.faces, self.others = _Texts(), _Texts(), _Texts(), {}
        # for each face line, how many vertices and normals stood before it: what negative numbers
        # count from
        self.vertices_before, self.normals_before = array("q"), array("q")
        for block in _blocks(data):
            self._read(_CONTINUED.sub(b" ", block).splitlines())
        for kept in (self.vertices, self.normals, self.faces):
            kept.counts = np.array(kept.counts, dtype=np.int64)

    def _read(self, lines):
        vertices, normals, faces = [], [], []
        first_vertex, first_normal = len(self.vertices.counts), len(self.normals.counts)
        for line in lines:
            words = line.split(None, 1)
            if not words:
                continue
            key = words[0]
            text = words[1] if len(words) == 2 else b""
            if b"#" in line:
                if key[:1] == b"#":
                    continue
                text = text.split(b"#", 1)[0]
            if key == b"v":
                vertices.append(text)
            elif key == b"f":
                faces.append(text)
                self.vertices_before.append(first_vertex + len(vertices))
                self.normals_before.append(first_normal + len(normals))
            elif key == b"vn":
                normals.append(text)
            elif key not in _SILENT:
                self.others[key] = self.others.get(key, 0) + 1
        self.vertices.take(vertices)
        self.normals.take(normals)
        self.faces.take(faces)


def _blocks(data):
    """The data in pieces that end where a line ends that is not continued."""
    start = len(_BYTE_ORDER_MARK) if data.startswith(_BYTE_ORDER_MARK) else 0
    while start < len(data):
        end = start + _BLOCK_BYTES
        while True:
            end = data.find(b"\n", end) + 1
            line = data[max(start, end - 100) : end].rstrip()
            if not end or not line.endswith(b"\\"):
                break
        yield data[start : end or len(data)]
        start = end or len(data)


def _vertices(path, lines, report):
    """(V, 3) float64 positions and (V, 3) uint8 colors or None."""
    counts = lines.counts
    wrong = np.flatnonzero((counts < 3) | (counts == 5) | (counts > 7))
    if len(wrong):
        raise MapFileError(
            "format",
            path,
            "vertex %d has %d values, not 3 (position), 4, 6 (with color) or 7"
            % (wrong[0], counts[wrong[0]]),
            "is the file damaged?",
        )
    values = numbers(path, b" ".join(lines.texts), "vertices")
    starts = np.cumsum(counts) - counts
    positions = values[starts[:, None] + np.arange(3)]
    if (counts == 4).any():
        report.note("left out: the weight of %d vertices", np.count_nonzero(counts == 4))
    if (counts < 6).any():
        if (counts >= 6).any():
            report.note("colors left out: only %d vertices have one", np.count_nonzero(counts >= 6))
        return positions, None
    if (counts == 7).any():
        report.note("left out: the alpha of the vertex colors")
    colors = values[starts[:, None] + np.arange(3, 6)]
    whole = colors.max() > 1 and (colors == np.rint(colors)).all()  # some programs write bytes
    return positions, colors_or_none(colors, {"u1"} if whole else {"f8"}, report)


def _corners(path, lines, vertex_count):
    """The vertex index from 0 of each corner of all faces."""
    first = [re.sub(rb"/[^\s]*", b"", text) if b"/" in text else text for text in lines.faces.texts]
    written = numbers(path, b" ".join(first), "faces", np.int64)
    counts = lines.faces.counts
    if len(written) != counts.sum():
        raise MapFileError("format", path, "a face has a corner without a vertex number", "")
    corners = _from_zero(written, counts, lines.vertices_before)
    check_corners(path, counts, corners, vertex_count, shown=written)
    return corners


def _from_zero(written, counts, before):
    """Indices from 0 of OBJ's numbers: from 1, or negative from the last one before the face.

    0 becomes -1.
    """
    if (written > 0).all():
        return written - 1
    last = np.repeat(np.array(before, dtype=np.int64), counts)
    return np.where(written > 0, written - 1, np.where(written < 0, last + written, -1))


def _normals(path, lines, corners, vertex_count, report):
    """(V, 3) float32 normals if every corner of a vertex has the same one.

    None with a note otherwise.
    """
    found = [b" ".join(_NORMAL_NUMBER.findall(text)) for text in lines.faces.texts]
    written = numbers(path, b" ".join(found), "normals of faces", np.int64)
    if len(written) != len(corners):
        report.note("normals left out: %d face corners have none", len(corners) - len(written))
        return None
    if not (lines.normals.counts == 3).all():
        raise MapFileError("format", path, "a normal (vn line) has not three values", "")
    normals = numbers(path, b" ".join(lines.normals.texts), "normals").reshape(-1, 3)
    index = _from_zero(written, lines.faces.counts, lines.normals_before)
    if ((index < 0) | (index >= len(normals))).any():
        at = np.flatnonzero((index < 0) | (index >= len(normals)))[0]
        raise MapFileError(
            "index", path, "a face refers to normal %d of %d" % (written[at], len(normals)), ""
        )
    result = np.zeros((vertex_count, 3))
    result[corners] = normals[index]
    if (result[corners] != normals[index]).any():
        report.note("normals left out: a vertex has different ones in different faces")
        return None
    return normals_or_none(result, report)
