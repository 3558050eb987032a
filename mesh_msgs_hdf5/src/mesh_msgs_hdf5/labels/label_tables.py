"""Labels as JSON and CSV, to be edited by other programs and read again without loss.

JSON: an object with "format": "mesh_labels", "version": 1, "uuid" (of the mesh), "faces" (how many
the mesh has) and "labels", a list of objects with "label" (the text), "class", "instance", "color"
([red, green, blue] from 0 to 255, or null) and "faces" (a list of face indices).

CSV: a line with the names of the columns, then a line for each run of consecutive faces of a label:
label, class, instance, color (#rrggbb or nothing), first_face, last_face. A label without faces has
one line where both are empty. Lines of one label belong together, wherever they are; their color
may stand in any of them. Of the columns only label and first_face are needed.

RViz reads and writes them, too (rviz_mesh_plugin, label_editing/label_files.h): tests hold both to
the same cases, mesh_msgs/test/label_files.json.
"""
import csv
import io
import json
import re
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.checks.check import checked_label
from mesh_msgs_hdf5.files.probe import read_file
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import split_label
from mesh_msgs_hdf5.model.mesh import Color, Label

FORMAT, VERSION = "mesh_labels", 1
COLUMNS = ("label", "class", "instance", "color", "first_face", "last_face")
NO_COLOR = "no color: #rrggbb, red,green,blue or none"
Labels = Dict[str, Label]


def labels_to_json(labels: Labels, uuid: str, face_count: int) -> str:
    """The text of a JSON file, one label in a line."""
    head = {"format": FORMAT, "version": VERSION, "uuid": uuid, "faces": face_count}
    lines = [json.dumps(_entry(text, label)) for text, label in labels.items()]
    body = ",\n  ".join(lines)
    return '%s,\n "labels": [\n  %s\n ]}\n' % (json.dumps(head)[:-1], body)


def _entry(text, label):
    class_name, instance = split_label(text)
    color = None if label.color is None else [int(value) for value in label.color]
    return {
        "label": text,
        "class": class_name,
        "instance": instance,
        "color": color,
        "faces": label.faces.tolist(),
    }


def labels_to_csv(labels: Labels) -> str:
    """The text of a CSV file."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for text, label in labels.items():
        head = (text, *split_label(text), color_text(label.color))
        faces = label.faces.astype(np.int64)
        breaks = np.flatnonzero(np.diff(faces) != 1) + 1
        for run in np.split(faces, breaks) if len(faces) else [()]:
            writer.writerow(head + ((run[0], run[-1]) if len(run) else ("", "")))
    return out.getvalue()


def color_text(color: Optional[Color]) -> str:
    """#rrggbb, or "" for None."""
    return "" if color is None else "#%02x%02x%02x" % tuple(color)


def parse_color(text: str) -> Optional[Color]:
    """The color of #rrggbb or red,green,blue; None of "" or none. Raises ValueError."""
    text = text.strip().lower()
    if text in ("", "none"):
        return None
    if re.fullmatch("#?[0-9a-f]{6}", text):
        text = text.lstrip("#")
        return tuple(int(text[i : i + 2], 16) for i in (0, 2, 4))
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 3 or not all(re.fullmatch("[0-9]{1,3}", part) for part in parts):
        raise ValueError(NO_COLOR)
    color = tuple(int(part) for part in parts)
    if max(color) > 255:
        raise ValueError(NO_COLOR)
    return color


def read_labels(path: PathLike, face_count: int) -> Tuple[Optional[str], Labels]:
    """(UUID of their mesh or None, labels) of a .json or .csv file.

    Every label is checked for a mesh of face_count faces. Raises MapFileError.
    """
    data = read_file(path)
    try:
        text = bytes(data).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _wrong(path, "byte %d is no UTF-8" % error.start) from error
    uuid = None
    if text.lstrip()[:1] in ("{", "["):
        uuid, labels = _from_json(path, text, face_count)
    else:
        labels = _from_csv(path, text, face_count)
    return uuid, {
        name: checked_label(path, name, label, face_count) for name, label in labels.items()
    }


def _wrong(path, message):
    hint = "mesh_tool labels export FILE OUT.json (or .csv) shows how it looks"
    return MapFileError("format", path, message, hint)


def _from_json(path, text, face_count):
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise _wrong(path, "it is no JSON: %s" % error) from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise _wrong(path, 'it does not say "format": "%s"' % FORMAT)
    if _whole(content.get("version")) != VERSION:
        raise _wrong(path, "it is of version %.20r, not %d" % (content.get("version"), VERSION))
    faces, entries = content.get("faces", face_count), content.get("labels")
    if _whole(faces) != face_count:
        message = "it is for a mesh of %.20r faces, this one has %d" % (faces, face_count)
        raise MapFileError("index", path, message, "take the map that it was made for")
    labels: Labels = {}
    for index, entry in enumerate(entries if isinstance(entries, list) else [None]):
        name = entry.get("label") if isinstance(entry, dict) else None
        if not isinstance(name, str) or not isinstance(entry.get("faces"), list):
            raise _wrong(path, 'labels[%d] has no "label" text or no list of "faces"' % index)
        if name in labels:
            raise _wrong(path, "label %s comes twice" % one_line(name))
        color = entry.get("color")
        labels[name] = Label(
            _face_array(path, name, entry["faces"]), _json_color(path, name, color)
        )
    return content.get("uuid") if isinstance(content.get("uuid"), str) else None, labels


def _whole(number):
    """The int that a number of JSON is, which may have a point; None: it is none."""
    if type(number) is float and number.is_integer():
        return int(number)
    return number if type(number) is int else None


def _face_array(path, name, faces):
    indices = [_whole(face) for face in faces]
    for place, index in enumerate(indices):
        if index is None or not 0 <= index < 1 << 32:
            message = "label %s: faces[%d] is %.20r, no face index"
            message = message % (one_line(name), place, faces[place])
            raise MapFileError("index", path, message, "whole numbers from 0")
    return np.array(indices, dtype=np.uint32)


def _json_color(path, name, color):
    if color is None:
        return None
    channels = [_whole(channel) for channel in color] if isinstance(color, list) else []
    if len(channels) != 3 or None in channels:
        message = "label %s: color %.40r is not [red, green, blue]" % (one_line(name), color)
        raise _wrong(path, message)
    return tuple(channels)


def _from_csv(path, text, face_count):
    first = text.split("\n", 1)[0]
    delimiter = ";" if ";" in first else ","
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    runs: Dict[str, List[Any]] = {}
    colors: Dict[str, Optional[Color]] = {}
    columns: Dict[str, int] = {}
    sizes: Dict[str, int] = {}
    try:
        for row in rows:
            if not columns:
                columns = {name.strip().lower(): i for i, name in enumerate(row)}
                if "label" not in columns or "first_face" not in columns:
                    message = "line 1 has no columns label and first_face, but %.80r" % row
                    raise _wrong(path, message)
            elif len(row) > 1 or "".join(row).strip():
                where = "line %d" % rows.line_num
                cell = {name: row[i] for name, i in columns.items() if i < len(row)}
                name, color, run = _csv_row(path, where, cell, face_count)
                runs.setdefault(name, []).append(run)
                sizes[name] = sizes.get(name, 0) + len(run)
                if sizes[name] > face_count:
                    raise _wrong(path, "%s: label %s has faces twice" % (where, one_line(name)))
                if color is not None and colors.setdefault(name, color) != color:
                    raise _wrong(path, "%s: label %s has two colors" % (where, one_line(name)))
    except csv.Error as error:
        raise _wrong(path, "line %d: %s" % (rows.line_num, error)) from error
    return {
        name: Label(np.concatenate(parts).astype(np.uint32), colors.get(name))
        for name, parts in runs.items()
    }


def _csv_row(path, where, cell, face_count):
    try:
        name, first = cell.get("label", ""), cell.get("first_face", "").strip()
        last = cell.get("last_face", "").strip() or first
        color = parse_color(cell.get("color", ""))
        if not first and not last:
            return name, color, np.zeros(0, dtype=np.int64)
        for face in (first, last):
            if not re.fullmatch("-?[0-9]+", face):
                raise ValueError("%.20r is no face" % face)
        first, last = int(first), int(last)
    except ValueError as error:
        raise _wrong(path, "%s: %s" % (where, error)) from error
    if first > last:
        message = "%s: faces %d to %d run backwards" % (where, first, last)
        raise MapFileError("index", path, message, "the first comes before the last")
    if not 0 <= first <= last < face_count:
        message = "%s: faces %d to %d, but the mesh has faces 0 to %d"
        message = message % (where, first, last, face_count - 1)
        raise MapFileError("index", path, message, "take the map that they were made for")
    return name, color, np.arange(first, last + 1)
