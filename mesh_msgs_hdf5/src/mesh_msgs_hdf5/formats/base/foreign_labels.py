"""Labels that other programs keep in another way: as numbers of faces or vertices, or as groups."""
import json
import types
from typing import Any, Dict, Iterable, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.files.probe import os_error, read_head
from mesh_msgs_hdf5.formats.base.report import ImportReport
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import MAX_LABELS, usable_label
from mesh_msgs_hdf5.model.mesh import Color, Label, Mesh


class ClassNames(NamedTuple):
    """What numbers of classes mean; labels, colors: texts of whole labels, and their colors, by
    numbers of instances.
    """

    classes: Dict[int, str]
    labels: Dict[int, str]
    colors: Mapping[int, Color] = types.MappingProxyType({})


# of an OBJ file: what may name its faces
GROUPS = {"groups": b"g", "objects": b"o", "materials": b"usemtl"}
# properties that are classes in the files of others
_USUAL = ("label", "category_id", "class_id")
_MOST_NAMES = 1 << 24  # bytes of a file of names


def take_numbered_labels(
    path: PathLike,
    mesh: Mesh,
    sources: Tuple[str, ...],
    names: ClassNames,
    report: ImportReport,
) -> None:
    """Make labels of the numbers that faces (or the vertices of faces) have.

    sources: the attribute (or layer) with their class, and perhaps that with their instance. names:
    those of classes that are not in it are called after the attribute: category_id 5 is category5.
    Numbers below 1 are
    no label. Raises MapFileError (label) where there is no such attribute, or too many labels.
    """
    columns = [_numbers(path, mesh, source) for source in sources]
    stem = sources[0][: -len("_id")] if sources[0].endswith("_id") else sources[0]
    labelled = np.flatnonzero(columns[0] > 0)
    rows = np.stack([column[labelled] for column in columns], axis=1)
    found, which = np.unique(rows, axis=0, return_inverse=True)
    if len(found) > MAX_LABELS:
        text = "%s would make %d labels, more than %d" % ("/".join(sources), len(found), MAX_LABELS)
        raise MapFileError("label", path, text, "name the property with the classes")
    order = np.argsort(which.ravel(), kind="stable")
    ends = np.cumsum(np.bincount(which.ravel(), minlength=len(found)))
    for row, faces in zip(found.tolist(), np.split(labelled[order], ends[:-1])):
        text = names.classes.get(row[0], "%s%d" % (stem, row[0]))
        if len(row) > 1:
            text = names.labels.get(row[1], "%s_%d" % (text, row[1]))
        _add(mesh, text, faces, names.colors.get(row[1]) if len(row) > 1 else None)
    report.note("%d labels of %s", len(found), ", ".join(sources))


def note_numbered_labels(mesh: Mesh, report: ImportReport) -> None:
    """Say that a mesh without labels has what labels could be made of."""
    for name in _USUAL:
        if not mesh.labels and any(
            name in members
            for members in (mesh.face_attributes, mesh.vertex_costs, mesh.vertex_attributes)
        ):
            report.note("--labels-from %s makes labels of what %s says", name, name)
            return


def take_grouped_labels(
    path: PathLike, mesh: Mesh, groups: Mapping[str, np.ndarray], what: str, report: ImportReport
) -> None:
    """Make a label of each group of faces, named as it is. Raises MapFileError (label)."""
    named = {text: faces for text, faces in groups.items() if len(faces)}
    if not named:
        raise MapFileError(
            "label", path, "the file has no %s to make labels of" % what, "leave out --labels-from"
        )
    if len(named) > MAX_LABELS:
        text = "the file has %d %s, more labels than %d" % (len(named), what, MAX_LABELS)
        raise MapFileError("label", path, text, "leave out --labels-from")
    for text, faces in named.items():
        _add(mesh, text, faces)
    report.note("%d labels of %s", len(named), what)


def parsed_class_names(path: PathLike, text: str) -> ClassNames:
    """The names of classes by their numbers, of a table as JSON or CSV.

    JSON: that of our own export ({"classes": [{"id": 1, "name": "tree"}, ...]}, which has labels,
    too), a list of such
    objects, or {"1": "tree"}. CSV: a line for each class, with its number and name. Raises
    MapFileError (format).
    """
    try:
        value = json.loads(text) if text.lstrip()[:1] in "{[" else None
        found = _of_csv(text) if value is None else _of_json(value)
        labels, colors = {}, {}
        if isinstance(value, dict) and "classes" in value:
            for entry in value.get("labels", ()):
                labels[int(entry["instance_id"])] = _text(entry["label"])
                if entry.get("color") is not None:
                    colors[int(entry["instance_id"])] = _color(entry["color"])
    except (LookupError, ValueError, TypeError, AttributeError, RecursionError) as error:
        reason = one_line(str(error))[:80]
        hint = '{"1": "tree"}, or lines of CSV: 1,tree'
        raise MapFileError(
            "format", path, "it is no table of classes: %s" % reason, hint
        ) from error
    classes = {number: usable_label(name) for number, name in found.items()}
    return ClassNames(classes, labels, colors)


def _of_json(value: Any) -> Dict[int, str]:
    if isinstance(value, dict) and "classes" in value:
        value = value["classes"]
    if isinstance(value, dict):
        return {int(number): _text(name) for number, name in value.items()}
    return {int(entry["id"]): _text(entry["name"]) for entry in value}


def _of_csv(text: str) -> Dict[int, str]:
    rows = [line.split(",") for line in text.splitlines() if line.strip()]
    if rows and not rows[0][0].strip().lstrip("-").isdigit():  # a head
        rows = rows[1:]
    return {int(row[0]): row[1].strip().strip('"') for row in rows}


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("%r is no name" % (value,))
    return value


def _color(value: Any) -> Color:
    red, green, blue = value
    if not all(type(level) is int and 0 <= level <= 255 for level in value):
        raise ValueError("%.40r is no color" % (value,))
    return red, green, blue


def _numbers(path: PathLike, mesh: Mesh, source: str) -> np.ndarray:
    """(F,) int64: the attribute of faces of that name, or what most corners of a face have."""
    if source in mesh.face_attributes:
        values = mesh.face_attributes[source]
        if _is_one_number(values):
            return _whole(path, source, values.reshape(-1))
    else:
        values = mesh.vertex_costs.get(source, mesh.vertex_attributes.get(source))
        if values is not None and _is_one_number(values):
            a, b, c = _whole(path, source, values.reshape(-1))[mesh.faces].T
            return np.where(b == c, b, a)
    known = [name for name, values in mesh.face_attributes.items() if _is_one_number(values)]
    known += list(mesh.vertex_costs)
    known += [name for name, values in mesh.vertex_attributes.items() if _is_one_number(values)]
    hint = "there are: " + ", ".join(known) if known else "the mesh has none"
    text = "there is no property %r of one number to make labels of" % one_line(source)[:80]
    raise MapFileError("label", path, text, hint)


def _is_one_number(values: np.ndarray) -> bool:
    return values.ndim == 1 or values.shape[1] == 1


def _whole(path: PathLike, source: str, values: np.ndarray) -> np.ndarray:
    if values.dtype.kind in "iu":
        return values.astype(np.int64)
    known = np.where(np.isnan(values), 0, values)
    wrong = np.flatnonzero((known != np.floor(known)) | (np.abs(known) > 2.0**53))
    if len(wrong):
        text = "%s is %g at %d, no whole number, %d in all"
        text = text % (one_line(source)[:80], values[wrong[0]], wrong[0], len(wrong))
        raise MapFileError("label", path, text, "a label needs a class")
    return known.astype(np.int64)


def _add(mesh: Mesh, text: str, faces: np.ndarray, color: Optional[Color] = None) -> None:
    text = usable_label(text)
    if text in mesh.labels:
        faces = np.union1d(mesh.labels[text].faces, faces)
        color = mesh.labels[text].color or color
    mesh.labels[text] = Label(faces.astype(np.uint32), color)


def read_class_names(path: str) -> ClassNames:
    """parsed_class_names() of a file. Raises MapFileError."""
    read_head(path)
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:
            return parsed_class_names(path, stream.read(_MOST_NAMES))
    except OSError as error:
        raise os_error(path, error) from error


def check_group_sources(path: PathLike, sources: Iterable[str]) -> List[str]:
    """The sources that an OBJ file has. Raises MapFileError (label) for others."""
    found = list(sources)
    for source in found:
        if source not in GROUPS:
            text = "an OBJ file has no %r to make labels of" % one_line(source)[:80]
            raise MapFileError("label", path, text, "there are: " + ", ".join(GROUPS))
    return found
