"""What the layers, labels and textures of a mesh say, as findings."""
from typing import Dict, Iterator, Optional

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.mesh import Label, Materials
from mesh_msgs_hdf5.validation.findings import NOTE, WARNING, MapFinding
from mesh_msgs_hdf5.validation.validate_topology import found


def check_layer(name: str, costs: np.ndarray) -> Iterator[MapFinding]:
    """Findings about the costs (V,) of one layer."""
    where = "layer " + one_line(name)
    yield from found("layer_negative", where, "costs are negative", costs < 0)
    unknown = np.isnan(costs)
    if len(costs) and unknown.all():
        yield MapFinding("layer_all_unknown", WARNING, where, "all its values are NaN")
        return
    share = "%.3g %% of its costs are unknown (NaN)" % (100 * unknown.mean())
    yield from found("layer_unknown", where, share, unknown, NOTE)


def check_attribute(place: str, name: str, values: np.ndarray) -> Iterator[MapFinding]:
    """Findings about the values (N,) or (N, C) of one attribute; place: "vertex" or "face"."""
    if values.dtype.kind == "f" and values.size:
        bad = ~np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        where = "%s attribute %s" % (place, one_line(name))
        text = "%s have NaN or inf" % {"vertex": "vertices", "face": "faces"}[place]
        yield from found("attribute_not_finite", where, text, bad, NOTE)


def check_labels(labels: Dict[str, Label], face_count: int) -> Iterator[MapFinding]:
    """Findings about all labels of a mesh."""
    owner = np.full(face_count, -1, dtype=np.int64)
    overlaps: Dict[tuple, list] = {}
    for index, (text, label) in enumerate(labels.items()):
        if not len(label.faces):
            where = "label " + one_line(text)
            yield MapFinding("label_empty", WARNING, where, "it has no faces")
        taken = label.faces[owner[label.faces] >= 0]
        for other in np.unique(owner[taken]):
            both = taken[owner[taken] == other]
            overlaps[int(other), index] = [int(both.min()), len(both)]
        owner[label.faces] = index
    names = list(labels)
    for (one, other), (first, count) in sorted(overlaps.items()):
        where = "label " + one_line(names[other])
        text = "faces are in label %s too" % one_line(names[one])
        yield MapFinding("labels_overlap", WARNING, where, text, first, count)


def check_textures(
    texture_indices, materials: Optional[Materials], coordinates: Optional[np.ndarray]
) -> Iterator[MapFinding]:
    """Findings about the indices of the textures, the materials and texture coordinates."""
    referred = set() if materials is None else set(materials.texture_indices.tolist())
    for index in sorted(set(texture_indices) - referred):
        yield MapFinding("texture_unused", WARNING, "texture %d" % index, "no material has it")
    if len(texture_indices) and coordinates is None:
        text = "there are textures, but no texture coordinates"
        yield MapFinding("texture_coordinates_missing", WARNING, "textures", text)
    if materials is not None:
        used = np.zeros(len(materials.colors), dtype=bool)
        used[materials.face_materials] = True
        yield from found("material_unused", "materials", "materials have no face", ~used)
