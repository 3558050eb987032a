"""Map files in which one thing is bad, made with plain h5py; see BAD."""
import re
from pathlib import Path
from typing import Callable, Dict, Iterable, NamedTuple

import h5py
import numpy as np


class Bad(NamedTuple):
    """damage: does it to the open part; member: of Mesh, what is not as it was; words: of the note;
    finding: where validate says it ("" for what it says nothing of).
    """

    damage: Callable[[h5py.Group], None]
    member: str
    words: str
    finding: str


def _replace(part, place, values):
    attributes = dict(part[place].attrs)
    del part[place]
    part[place] = values
    part[place].attrs.update(attributes)


def _normal(part):
    part["channels/vertex_normals"][5] = np.nan


def _no_normals(part):
    part["channels/vertex_normals"][...] = np.nan


def _alpha(part):
    colors = part["channels/vertex_colors"][()]
    alpha = np.full((len(colors), 1), 255, "u1")
    alpha[7] = 9
    _replace(part, "channels/vertex_colors", np.hstack([colors, alpha]))


def _coordinates(part):
    part["textures/coords"][3 * 11] = np.nan


def _layer(part):
    part["channels/height_diff"][9] = -np.inf


def _face_cost(part):
    part["face_attributes/cost"][8] = -np.inf


def _label_face(part):
    part["labels/tree/2"][3] = 999


def _label_type(part):
    _replace(part, "labels/tree/2", np.zeros(3, "f4"))


def _label_color(part):
    part["labels/tree/1"].attrs["color"] = [1, 2]


def _label_name(part):
    _add_label(part, "tr\x01ee")


def _label_no_utf8(part):  # a no-break space in Latin-1
    group = h5py.h5g.create(part["labels"].id, b"tree\xa0x")
    h5py.Group(group)["1"] = np.array([1, 2], "u4")


def _label_twice(part):
    _add_label(part, "x").attrs["label"] = "tree_1"


def _add_label(part, name):
    group = part["labels"].create_group(name)
    group["1"] = np.array([1, 2], "u4")
    return group["1"]


def _layer_name(part):
    part["channels/slo\u00a0pe"] = np.zeros((40, 1), "f4")


def _features(part):
    for name in ("20", "21"):
        part["channels/texture_features"][name] = np.zeros(128, "f4")
        part["channels/texture_features"][name].attrs["vector"] = np.zeros(3, "f4")


def _feature(part):
    part["channels/texture_features/3"][7] = np.nan


def _texture(part):
    _replace(part, "textures/images/10", np.zeros((5, 7, 2), "u1"))


def _materials(part):
    part["textures/mat_face_indices"][33] = 77


def _parameters(part):
    part["channels/height_diff"].attrs["parameters"] = "{"


def _seams(part):
    part["seams/originals"] = np.array([3, 3, 38], "u4")


def _source(part):
    part.attrs["source"] = "["


def _vertices(part):
    """No UUID: this is what a program of others stores."""
    vertices = part["channels/vertices"][()].astype("f8")
    vertices[4, 1] += 1e-9
    _replace(part, "channels/vertices", vertices)
    for name in ("uuid", "schema_version"):
        del part.attrs[name]


def _wide_layer(part):
    costs = part["channels/height_diff"][()].astype("f8")
    costs[12] = 0.1
    _replace(part, "channels/height_diff", costs)


def _link(part):
    del part["channels/vertex_colors"]
    part["channels/vertex_colors"] = h5py.ExternalLink("/etc/passwd", "/")


BAD: Dict[str, Bad] = {
    "normal": Bad(_normal, "vertex_normals", "1 normals of .* first row 5", "vertex_normals"),
    "no normals": Bad(_no_normals, "vertex_normals", "row 0 .* 40 in all", "vertex_normals"),
    "alpha": Bad(_alpha, "vertex_colors", "alpha .* in row 7, 1 in all", "vertex_colors"),
    "link": Bad(_link, "vertex_colors", "vertex_colors is an external link", "vertex_colors"),
    "coordinates": Bad(
        _coordinates, "texture_coordinates", "1 tex.* first vertex 11", "texture_coordinates"
    ),
    "layer": Bad(_layer, "vertex_costs", "height_diff: 1 .* first vertex 9", "layer height_diff"),
    "wide layer": Bad(_wide_layer, "vertex_costs", "height_diff is float64; 1", "layer height"),
    "layer name": Bad(_layer_name, "vertex_costs", "not printable: it is read as slo_pe", ""),
    "parameters": Bad(_parameters, "layer_parameters", "height_diff is not JSON", "layer height"),
    "face cost": Bad(_face_cost, "face_attributes", "cost: 1 .* first face 8", "face attribute"),
    "label face": Bad(
        _label_face, "labels", "1 of 60 faces of label tree_2.* 3, 999", "label tree"
    ),
    "label type": Bad(_label_type, "labels", "label tree_2 is of type float32", "label tree_2"),
    "label color": Bad(_label_color, "labels", "color of .*tree/1 is not 3", "label tree_1"),
    "label name": Bad(_label_name, "labels", "control character: .* as tr_ee_1", "labels"),
    "label of no text": Bad(
        _label_no_utf8, "labels", "a name in /mesh/labels is not UTF", "labels"
    ),
    "label twice": Bad(_label_twice, "labels", "tree_1 is there twice, .* as tree_1_2", "labels"),
    "kinds of features": Bad(
        _features,
        "features",
        "2 features that have not 64 .* 12 others do, first .*/20",
        "features",
    ),
    "feature": Bad(_feature, "features", "texture_features/3 is not finite", "features"),
    "texture": Bad(_texture, "textures", "images/10 has the shape", "texture 10"),
    "materials": Bad(_materials, "materials", "face 33 refers to material 77", "materials"),
    "seams": Bad(_seams, "seam_originals", "copy 2 is one of vertex 38,", "seam_originals"),
    "source": Bad(_source, "source", "source is not JSON", "source"),
    "vertices": Bad(
        _vertices, "vertices", "float64; 1 values .* first row 4, column 1", "vertices"
    ),
}


def noted(notes: Iterable[str], kind: str) -> int:
    """How many notes say what is bad."""
    return len([note for note in notes if re.search(BAD[kind].words, note)])


def write_bad(path: Path, data: bytes, kind: str) -> None:
    """A map file like the one with this data (of the fixture rich_data) in which this is bad."""
    path.write_bytes(data)
    with h5py.File(path, "r+") as file:
        BAD[kind].damage(file["mesh"])
