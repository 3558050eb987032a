"""STL (binary and ASCII) to Mesh, and Mesh to binary STL.

Corners at exactly the same position become one vertex when it is read, the report says so.
"""
import re

import numpy as np

from mesh_msgs_hdf5.formats.base.export_parts import MEANING, Export, check_size
from mesh_msgs_hdf5.formats.base.numbers_text import numbers
from mesh_msgs_hdf5.formats.base.options import Options, placed
from mesh_msgs_hdf5.formats.base.polygons import triangle_edges, weld
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mesh import Mesh

_HEADER = 84
_LOOK = 4096
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"vertex\s+(\S+\s+\S+\s+\S+)")


def read_stl(path: PathLike, data: bytes, options: Options, report: ImportReport) -> Mesh:
    """A Mesh of an STL file's bytes."""
    announced = int.from_bytes(data[80:_HEADER], "little") if len(data) >= _HEADER else 0
    size = _HEADER + announced * TRIANGLE.itemsize
    # the header of a binary file may begin like text too, but what follows has zero bytes
    is_text = data.lstrip()[:5].lower() == b"solid" and b"\0" not in data[:_LOOK]
    if len(data) >= _HEADER and (len(data) == size or not is_text):
        corners = _binary(path, data, announced, size, report)
    else:
        corners = _ascii(path, data, report)
    if not len(corners):
        raise MapFileError("no_faces", path, "the STL file has no faces", "a map needs triangles")
    triangles = np.arange(len(corners)).reshape(-1, 3)
    corners, origin = placed(
        path, corners, "corner", options, report, edges=lambda: triangle_edges(triangles)
    )
    vertices, index = weld(corners, report)
    return Mesh(vertices, index.reshape(-1, 3).astype(np.uint32), origin=origin)


def _binary(path, data, announced, size, report):
    if len(data) < size:
        raise MapFileError(
            "truncated",
            path,
            "the file is cut off, or no STL: it announces %d triangles, but holds %d"
            % (announced, (len(data) - _HEADER) // TRIANGLE.itemsize),
            "copy or fetch it again",
        )
    triangles = np.frombuffer(data, TRIANGLE, announced, _HEADER)
    colored = np.count_nonzero(triangles["attribute"])
    if colored:
        report.note("left out: the attribute (color) of %d triangles", colored)
    if len(data) > size:
        report.note("left out: %d bytes after the last triangle", len(data) - size)
    return np.ascontiguousarray(triangles["corners"]).reshape(-1, 3)


def _ascii(path, data, report):
    text = data.lower()
    if not text.lstrip().startswith(b"solid"):
        raise MapFileError("format", path, "it is no STL file", "check the name")
    if b"endsolid" not in text[max(text.rfind(b"endfacet"), 0) :]:
        raise MapFileError(
            "truncated",
            path,
            "the file is cut off: no endsolid at its end",
            "copy or fetch it again",
        )
    facets, words = text.count(b"endfacet"), _VERTEX.findall(text)
    if len(words) != 3 * facets:
        raise MapFileError(
            "format",
            path,
            "%d facets have %d corners, not three each" % (facets, len(words)),
            "is the file damaged?",
        )
    solids = text.count(b"endsolid")
    if solids > 1:
        report.note("%d solids became one mesh", solids)
    return numbers(path, b" ".join(words), "corners").reshape(-1, 3)


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
    export.leave_out(mesh, "STL", *MEANING)
    export.note("STL has no vertices of its own: reading it welds corners at the same position")
    return export
