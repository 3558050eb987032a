"""PLY to Mesh: vertex order and count are kept."""
from typing import Optional, Set

import numpy as np

from mesh_msgs_hdf5 import schema
from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.exact import narrowed
from mesh_msgs_hdf5.mesh import Mesh
from mesh_msgs_hdf5.formats.ply import read_elements
from mesh_msgs_hdf5.formats.polygons import check_corners, triangulate
from mesh_msgs_hdf5.report import ImportReport, note_costs, note_rounding

_POSITION, _NORMAL = ("x", "y", "z"), ("nx", "ny", "nz")
_COLORS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
_TEXTURE = {"s", "t", "u", "v", "texture_u", "texture_v"}
# floats that are no costs, even where they stand alone
_NO_LAYERS = _TEXTURE.union(_NORMAL, *_COLORS, ["alpha", "diffuse_alpha"])
_CORNERS = ("vertex_indices", "vertex_index")


def read_ply(path: PathLike, data: bytes, report: ImportReport) -> Mesh:
    """A Mesh of a PLY file's bytes.

    Float properties of the vertices become layers, red, green and blue become colors (bytes, or
    floats from 0 to 1).
    """
    elements, left_over = read_elements(path, data)
    vertex, face = elements.get("vertex"), elements.get("face")
    if vertex is None or not set(_POSITION) <= set(vertex.values):
        raise MapFileError("format", path, "the PLY file has no vertices with x, y and z", "")
    floats = {p.name for p in vertex.properties if p.type[0] == "f" and not p.count}
    vertices, change = narrowed(_columns(vertex, _POSITION), path, "vertex")
    note_rounding(report, change)
    strips = "tristrips" in elements
    mesh = Mesh(vertices, _faces(path, face, len(vertices), strips, report))
    used = set(_POSITION)
    if set(_NORMAL) <= floats:
        used |= set(_NORMAL)
        mesh.vertex_normals = normals_or_none(_columns(vertex, _NORMAL), report)
    for names in _COLORS:
        if mesh.vertex_colors is None and set(names) <= set(vertex.values):
            used |= set(names)
            kinds = {p.type for p in vertex.properties if p.name in names}
            mesh.vertex_colors = colors_or_none(_columns(vertex, names), kinds, report)
    for name, values in vertex.values.items():
        if name in floats - used - _NO_LAYERS:
            used.add(name)
            _add_layer(path, mesh, name, values, report)
    _note_left_out(vertex, used | _opaque_alpha(vertex), elements, left_over, report)
    return mesh


def _columns(element, names):
    columns = [element.values[name] for name in names]
    return np.stack(columns, axis=1).astype(np.result_type(*columns).newbyteorder("="), copy=False)


def _faces(path, face, vertex_count, strips, report):
    found = [name for name in _CORNERS if face is not None and name in face.lists]
    if not found:
        raise MapFileError(
            "no_faces",
            path,
            "the PLY file has no faces (element face with a list vertex_indices)",
            "triangle strips are not read: save it as triangles, with MeshLab for example"
            if strips
            else "a map needs triangles: mesh the points first",
        )
    counts, corners = face.lists[found[0]]
    if corners.dtype.kind == "f":
        whole = corners == np.floor(corners)
        if not whole.all():
            at = np.flatnonzero(~whole)[0]
            raise MapFileError(
                "index", path, "vertex index %s is no whole number" % corners[at], ""
            )
        corners = corners.astype(np.int64)
    check_corners(path, counts, corners, vertex_count)
    return triangulate(counts, corners, report)


def normals_or_none(normals: np.ndarray, report: ImportReport) -> Optional[np.ndarray]:
    """(V, 3) float32 normals, or None with a note if one is not finite."""
    with np.errstate(over="ignore"):
        normals = np.ascontiguousarray(normals, dtype=np.float32)
    wrong = np.flatnonzero(~np.isfinite(normals).all(axis=1))
    if not len(wrong):
        return normals
    report.note(
        "normals left out: %d of them are not finite, first at vertex %d", len(wrong), wrong[0]
    )
    return None


def colors_or_none(
    colors: np.ndarray, kinds: Set[str], report: ImportReport
) -> Optional[np.ndarray]:
    """(V, 3) uint8 colors of bytes, or of floats from 0 to 1; None with a note if they are neither.

    kinds: the types in the file ({"u1"}, {"f4"}, ...).
    """
    is_float = any(kind[0] == "f" for kind in kinds)
    scale = 255 if is_float else 1
    wrong = ~((colors >= 0) & (colors <= 255 / scale)).all(axis=1)
    if wrong.any():
        report.note(
            "colors left out: %d of them are not within 0..%d, first at vertex %d",
            np.count_nonzero(wrong),
            255 // scale,
            np.flatnonzero(wrong)[0],
        )
        return None
    return np.ascontiguousarray(np.rint(colors * scale) if is_float else colors, dtype=np.uint8)


def _add_layer(path, mesh, name, values, report):
    stored = name.replace("/", "_")
    try:
        schema.check_layer_name(path, stored)
    except MapFileError as error:
        report.note("property %s left out: %s", name, error.message)
        return
    if stored in mesh.vertex_costs:
        report.note("property %s left out: there is a layer of that name already", name)
        return
    with np.errstate(over="ignore"):
        costs = np.ascontiguousarray(values, dtype=np.float32)
    overflow = np.flatnonzero(np.isinf(costs) & ~np.isinf(values))
    if len(overflow):
        raise MapFileError(
            "not_finite",
            path,
            "property %s of vertex %d is too large for float32 (%g), %d in all"
            % (name, overflow[0], values[overflow[0]], len(overflow)),
            "repair it where it was made; inf means lethal",
        )
    mesh.vertex_costs[stored] = costs
    note_costs(report, stored, costs)


def _opaque_alpha(vertex):
    """Names of the alpha property if it says nothing (all opaque)."""
    alpha = vertex.values.get("alpha")
    kinds = {p.type[0] for p in vertex.properties if p.name == "alpha"}
    opaque = alpha is not None and (alpha == (1.0 if "f" in kinds else 255)).all()
    return {"alpha"} if opaque else set()


def _note_left_out(vertex, used, elements, left_over, report):
    for p in vertex.properties:
        if p.name not in used:
            report.note(
                "left out: property %s of the vertices (%s)", p.name, "list" if p.count else p.type
            )
    for element in elements.values():
        if element.name == "face":
            for p in element.properties:
                if p.name not in _CORNERS:
                    report.note(
                        "left out: %s of the faces (property %s); only corners of faces are read",
                        "texture coordinates" if p.name == "texcoord" else "values",
                        p.name,
                    )
        elif element.name != "vertex" and element.rows:
            report.note("left out: element %s (%d rows)", element.name, element.rows)
    if left_over:
        report.note("left out: %d values after the last element", left_over)
