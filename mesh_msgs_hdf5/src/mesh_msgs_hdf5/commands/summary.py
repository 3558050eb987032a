"""What is in a mesh file, as plain values."""
import os
from typing import Any, Callable, Dict, Iterable, List, Optional

import numpy as np

from mesh_msgs_hdf5.formats.any_mesh import Members
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.labels.map_contents import open_map
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import split_label
from mesh_msgs_hdf5.model.layer_meaning import NONE, OTHER, computed_with, meaning_of


def summarize(path: str, part: Optional[str] = None, fast: bool = False) -> Dict[str, Any]:
    """What a file holds: counts, bounds in meters, layers, labels, textures, frame, UUID, ...

    Of a map file the arrays that have to be known are read, not the faces, normals and colors;
    with fast none is. Other formats are read as a whole. The result is made of dicts, lists, texts
    and numbers. Raises MapFileError.
    """
    file, form, opening_notes, _ = open_map(path, part)
    notes = list(opening_notes)
    with file:
        summary = _summary(file, fast and form == "HDF5", notes)
        summary["unsaved_labels"] = file.unsaved_count
        notes += list(file.notes) + file.label_notes
    scans = isolated("scans", path) if form == "HDF5" else []
    summary["scans"] = {
        "count": len(scans),
        "points": sum(scan.get("points", 0) for scan in scans),
        "images": sum(len(scan.get("images", ())) for scan in scans),
    }
    if form != "HDF5":
        summary["arrays_read"] = None
    head = {"path": os.fsdecode(path), "format": form, "file_bytes": os.stat(path).st_size}
    return {**head, **summary, "notes": list(dict.fromkeys(notes))}


def readable(
    names: Iterable[Any], summarize_one: Callable[[Any], Dict[str, Any]], notes: List[str]
) -> List[Dict[str, Any]]:
    """What is to be said of each that can be read; notes get what is wrong with the others."""
    found = []
    for name in names:
        try:
            found.append(summarize_one(name))
        except MapFileError as error:
            if error.code in ("crashed", "timeout", "changed"):
                raise
            notes.append("left out: " + error.message)
    return found


def _summary(file: Members, fast: bool, notes: List[str]) -> Dict[str, Any]:
    read: List[str] = []
    summary: Dict[str, Any] = {
        "schema": file.schema,
        "schema_version": file.schema_version,
        "part": file.part,
        "parts": list(file.parts),
        "vertices": file.vertex_count,
        "faces": file.face_count,
        "normals": file.has_normals,
        "colors": file.has_colors,
        "frame_id": file.frame_id,
        "origin": [float(value) for value in file.origin],
        "crs": file.crs,
        # files of ours say it; for others it would have to be computed
        "uuid": file.uuid if file.schema_version or not fast else None,
        "source": file.source,
    }
    summary.update(_bounds(file, fast, read))
    for key, names, about in (
        ("layers", file.layer_names(), layer_summary),
        ("vertex_attributes", file.vertex_attribute_names(), vertex_attribute_summary),
        ("face_attributes", file.face_attribute_names(), face_attribute_summary),
        ("textures", file.texture_indices(), _texture),
    ):
        summary[key] = readable(names, lambda name: about(file, name, fast, read), notes)
    summary["texture_coordinates"] = None if fast else file.texture_coordinates is not None
    if summary["texture_coordinates"]:
        read.append("texture coordinates")
    summary["seams"] = None if fast or not file.has_seams else _seams(file, read)
    materials = None if fast else file.materials
    summary["materials"] = None
    if materials is not None:
        read.append("materials")
        textured = int(np.count_nonzero(materials.texture_indices >= 0))
        summary["materials"] = {"count": len(materials.colors), "textured": textured}
    summary["labels"] = _labels(file, fast, read)
    features = None if fast else file.features
    summary["features"] = None
    if features is not None:
        read.append("features")
        count, dimensions = features.descriptors.shape
        summary["features"] = {"count": count, "dimensions": dimensions}
    summary["other_contents"] = file.other_contents()
    summary["arrays_read"] = read
    return summary


def _bounds(file, fast, read):
    if fast:
        return {"bounds": None, "georeferenced": None}
    read.append("vertices")
    vertices = file.vertices
    low, high = (
        (vertices.min(axis=0), vertices.max(axis=0)) if len(vertices) else (np.zeros(3),) * 2
    )
    bounds = {"min": low.tolist(), "max": high.tolist()}
    if not any(file.origin):
        return {"bounds": bounds, "georeferenced": None}
    origin = np.array(file.origin, dtype=np.float64)
    placed = {"min": (low + origin).tolist(), "max": (high + origin).tolist()}
    return {"bounds": bounds, "georeferenced": placed}


def layer_summary(file: Members, name: str, fast: bool = False, read=None) -> Dict[str, Any]:
    """Name, parameters and, unless fast, costs_summary() of a layer; read gets what was read.

    Where the file says what the values mean also unit, comparison, threshold (None: there is none)
    and rule, a text; lethal are then those by that rule, not only +inf.
    """
    parameters = file.layer_parameters(name)
    meaning = meaning_of(parameters)
    entry = {"name": name, "parameters": computed_with(parameters)}
    if meaning is not None:
        entry.update(unit=meaning.unit, comparison=meaning.comparison, rule=meaning.rule_text())
        entry["threshold"] = None if meaning.comparison in (NONE, OTHER) else meaning.threshold
    if not fast:
        costs = file.vertex_costs(name)
        _note(read, "layer " + name)
        entry.update(costs_summary(costs))
        if meaning is not None:
            entry["lethal"] = meaning.count_lethal(costs)
    return entry


def vertex_attribute_summary(
    file: Members, name: str, fast: bool = False, read=None
) -> Dict[str, Any]:
    """As layer_summary(); unless fast also the type of its numbers."""
    return _attribute_summary(file, "vertex", name, fast, read)


def face_attribute_summary(
    file: Members, name: str, fast: bool = False, read=None
) -> Dict[str, Any]:
    """Likewise."""
    return _attribute_summary(file, "face", name, fast, read)


def _attribute_summary(file, place, name, fast, read):
    entry = {"name": name, "parameters": getattr(file, place + "_parameters")(name)}
    if not fast:
        values = getattr(file, place + "_attribute")(name)
        _note(read, "%s attribute %s" % (place, name))
        columns = 1 if values.ndim == 1 else values.shape[1]
        entry["type"] = str(values.dtype) + ("" if columns == 1 else " x %d" % columns)
        entry.update(costs_summary(values))
    return entry


def _note(read: Optional[List[str]], name):
    if read is not None:
        read.append(name)


def _texture(file, index, fast, read):
    if fast:
        return {"index": index}
    height, width, channels = file.texture(index).shape
    read.append("texture %d" % index)
    return {"index": index, "width": width, "height": height, "channels": channels}


def _seams(file, read):
    """Of a mesh with copies of vertices along seams of textures; None if its table is no good."""
    originals = file.seam_originals
    if originals is None:
        return None
    read += ["faces", "copies along seams"]
    return {
        "copies": len(originals),
        "vertices": len(np.unique(originals)),
        "parent_uuid": file.parent_uuid,
    }


def _labels(file, fast, read):
    names = file.label_names()
    labels = {} if fast else file.labels()
    classes: Dict[str, Dict[str, Any]] = {}
    for name in names:
        entry = classes.setdefault(split_label(name)[0], {"labels": 0, "faces": None})
        entry["labels"] += 1
        if name in labels:
            entry["faces"] = (entry["faces"] or 0) + len(labels[name].faces)
    if labels:
        read.append("labels")
    return {"count": len(names), "classes": classes}


def costs_summary(costs: np.ndarray) -> Dict[str, Any]:
    """Range of the finite values, and counts of lethal, unknown and negative ones.

    min and max are None if no value is finite.
    """
    finite = costs[np.isfinite(costs)]
    number = float if costs.dtype.kind == "f" else int
    return {
        "min": number(finite.min()) if len(finite) else None,
        "max": number(finite.max()) if len(finite) else None,
        "lethal": int(np.count_nonzero(costs == np.inf)),
        "unknown": int(np.count_nonzero(np.isnan(costs))),
        "negative": int(np.count_nonzero(costs < 0)),
    }
