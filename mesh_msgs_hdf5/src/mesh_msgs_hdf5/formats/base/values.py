"""Normals, colors, layers and attributes of files as a mesh has them; what it cannot is noted."""
from typing import Any, Dict, Optional, Set

import numpy as np

from mesh_msgs.checks.findings import narrowed
from mesh_msgs.text import one_line
from mesh_msgs_hdf5.formats.base.report import ImportReport, note_costs
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.mending import mended_coordinates
from mesh_msgs_hdf5.model.mesh import Mesh


def normals_or_none(normals: np.ndarray, report: ImportReport) -> Optional[np.ndarray]:
    """(V, 3) float32 normals, or None with a note if one is not finite."""
    return _finite_or_none("normals", normals, report)


def coordinates_or_none(
    coordinates: np.ndarray, faces: np.ndarray, report: ImportReport
) -> Optional[np.ndarray]:
    """(V, 2) float32 texture coordinates of vertices with these faces (F, 3).

    Those that are not finite become the mean of those beside them, with a note; None where all are.
    """
    values = np.ascontiguousarray(narrowed(coordinates))
    bad = ~np.isfinite(values).all(axis=1)
    if bad.all():
        return _finite_or_none("texture coordinates", values, report)
    if bad.any():
        text = "%d texture coordinates are not finite: the mean of those beside them, first vertex"
        report.note(text + " %d", np.count_nonzero(bad), bad.argmax())
        values = mended_coordinates(values, bad, faces)
    return values


def _finite_or_none(what, values, report):
    values = np.ascontiguousarray(narrowed(values))
    wrong = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if not len(wrong):
        return values
    text = "%s left out: %d of them are not finite, first at vertex %d"
    report.note(text, what, len(wrong), wrong[0])
    return None


def colors_or_none(
    colors: np.ndarray, kinds: Set[str], report: ImportReport, place: str = "vertex"
) -> Optional[np.ndarray]:
    """(N, 3) uint8 colors of bytes, or of floats from 0 to 1; None with a note if they are neither.

    kinds: the types in the file ({"u1"}, {"f4"}, ...); place: what has a color.
    """
    is_float = any(kind[0] == "f" for kind in kinds)
    scale = 255 if is_float else 1
    wrong = ~((colors >= 0) & (colors <= 255 / scale)).all(axis=1)
    if wrong.any():
        report.note(
            "colors left out: %d of them are not within 0..%d, first at %s %d",
            np.count_nonzero(wrong),
            255 // scale,
            place,
            np.flatnonzero(wrong)[0],
        )
        return None
    return np.ascontiguousarray(np.rint(colors * scale) if is_float else colors, dtype=np.uint8)


def add_layer(
    path: PathLike,
    mesh: Mesh,
    name: str,
    values: np.ndarray,
    report: ImportReport,
    parameters: Optional[Dict[str, Any]] = None,
) -> None:
    """Give the mesh a layer; a slash in its name becomes _.

    Whole numbers are one if float32 holds each exactly, else a vertex attribute. MapFileError
    not_finite where a float is too large for it.
    """
    stored = one_line(name.replace("/", "_"))
    try:
        schema.check_layer_name(path, stored)
    except MapFileError as error:
        report.note("property %s left out: %s", name, error.message)
        return
    if stored in mesh.vertex_costs or stored in mesh.vertex_attributes:
        report.note("property %s left out: there is a layer of that name already", name)
        return
    costs = np.ascontiguousarray(narrowed(values))
    if values.dtype.kind in "iu":
        if (costs.astype(np.longdouble) != values).any():
            add_attribute(path, mesh, "vertex", stored, values, report, parameters)
            return
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
    if parameters:
        mesh.layer_parameters[stored] = parameters
    note_costs(report, stored, costs)


def add_attribute(
    path: PathLike,
    mesh: Mesh,
    place: str,
    name: str,
    values: np.ndarray,
    report: ImportReport,
    parameters: Optional[Dict[str, Any]] = None,
) -> None:
    """Give the vertices or faces (place: "vertex", "face") an attribute (N,) or (N, C) in its own
    type; a slash becomes _.
    """
    stored = one_line(name.replace("/", "_"))
    check, noun, taken = {
        "vertex": (schema.check_vertex_attribute_name, "vertices", mesh.vertex_costs),
        "face": (schema.check_face_attribute_name, "faces", ()),
    }[place]
    try:
        check(path, stored)
    except MapFileError as error:
        report.note("property %s of the %s left out: %s", name, noun, error.message)
        return
    attributes = getattr(mesh, place + "_attributes")
    if stored in attributes or stored in taken:
        report.note("property %s of the %s left out: the name is taken", name, noun)
        return
    attributes[stored] = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("="))
    if parameters:
        getattr(mesh, place + "_parameters")[stored] = parameters
