"""What a format has no place for, as remarks: JSON objects in comments (or extras) of our exports.

Each remark says in its first key what it is about: {"layer": name, "property": name in the file,
"parameters": {...}}. Other programs skip them; our import brings back what they tell.
"""
import json
from typing import Any, Dict, Iterable, List

import numpy as np

from mesh_msgs_hdf5.checks.check import checked_crs, checked_object, checked_origin, to_json
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.carried_mesh import mark_silent
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import check_label
from mesh_msgs_hdf5.model.mesh import Label, Mesh

PREFIX = "mesh_tools "
# types that remarks may name
NUMBERS = ("f2", "f4", "f8", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8")
Remark = Dict[str, Any]


def remark_texts(path: PathLike, remarks: Iterable[Remark]) -> List[str]:
    """A line of ASCII for each remark."""
    return [PREFIX + to_json(path, "a remark", remark) for remark in remarks]


def parsed_remarks(lines: Iterable[str], report: ImportReport) -> List[Remark]:
    """The remarks among the comments of a file; what cannot be read as one is noted."""
    found, wrong = [], 0
    for line in lines:
        text = line.strip()
        if not text.startswith(PREFIX):
            continue
        try:
            remark = json.loads(text[len(PREFIX) :])
        except (ValueError, RecursionError):
            remark = None
        if isinstance(remark, dict):
            found.append(remark)
        else:
            wrong += 1
    if wrong:
        report.note("left out: %d remarks (comments that begin with mesh_tools) are damaged", wrong)
    return found


def about(remarks: Iterable[Remark], key: str, kind: Any = str) -> List[Remark]:
    """Those remarks whose subject is key, named by a value of this kind."""
    return [
        remark
        for remark in remarks
        if isinstance(remark.get(key), kind) and not isinstance(remark[key], bool)
    ]


def mesh_remark(mesh: Mesh) -> List[Remark]:
    """Frame, origin, reference system and provenance, where they are not the default."""
    remark: Remark = {}
    if mesh.frame_id != "map":
        remark["frame_id"] = mesh.frame_id
    if tuple(mesh.origin) != (0.0, 0.0, 0.0):
        remark["origin"] = [float(value) for value in mesh.origin]
    if mesh.crs:
        remark["crs"] = mesh.crs
    if mesh.source:
        remark["source"] = mesh.source
    if not all(mesh.layer_parameters.get(name) for name in mesh.vertex_costs):
        remark["uuid"] = mesh.uuid  # the geometry that those layers are of
    return [{"mesh": remark}] if remark else []


def mark_foreign_layers(mesh: Mesh, remarks: Iterable[Remark]) -> None:
    """Layers that do not say how they were computed are carried ones, unless the geometry is that
    which our export names: another program may have changed it."""
    named = [remark["mesh"].get("uuid") for remark in about(remarks, "mesh", dict)[:1]]
    own = {remark["layer"] for remark in about(remarks, "layer")}
    mark_silent(mesh, "import", but=own if named == [mesh.uuid] else ())


def remarked_origin(remarks: Iterable[Remark]) -> Any:
    """The origin that an export names, or (0, 0, 0)."""
    for remark in about(remarks, "mesh", dict):
        try:
            return checked_origin("", remark["mesh"].get("origin", (0.0, 0.0, 0.0)))
        except MapFileError:
            break
    return 0.0, 0.0, 0.0


def take_mesh_remark(
    path: PathLike, mesh: Mesh, remarks: Iterable[Remark], report: ImportReport
) -> None:
    """Give the mesh what mesh_remark wrote, except for the origin."""
    for remark in about(remarks, "mesh", dict)[:1]:
        try:
            values = remark["mesh"]
            if isinstance(values.get("frame_id"), str):
                schema.check_frame_id(path, values["frame_id"])
                mesh.frame_id = values["frame_id"]
            mesh.crs = checked_crs(path, values.get("crs", ""))
            if "source" in values:
                mesh.source = checked_object(path, "the source", values["source"])
        except MapFileError as error:
            report.note("a remark was left out: %s", error.message)


def parameters_of(remark: Remark) -> Dict[str, Any]:
    """The parameters in a remark; {} if there are none."""
    found = remark.get("parameters")
    return found if isinstance(found, dict) else {}


def add_label(
    path: PathLike, mesh: Mesh, remark: Remark, faces: np.ndarray, report: ImportReport
) -> None:
    """Give the mesh the label of a remark with these faces."""
    try:
        check_label(path, remark["label"])
    except MapFileError as error:
        report.note("left out: %s", error.message)
        return
    mesh.labels[remark["label"]] = Label(faces.astype(np.uint32), color_of(remark))


def color_of(remark: Remark) -> Any:
    """(red, green, blue) of a remark, or None."""
    color = remark.get("color")
    sound = isinstance(color, list) and len(color) == 3
    if sound and all(type(value) is int and 0 <= value <= 255 for value in color):
        return tuple(color)
    return None


def color_list(color: Any) -> Any:
    """The color as JSON has it: a list, or None."""
    return None if color is None else [int(value) for value in color]
