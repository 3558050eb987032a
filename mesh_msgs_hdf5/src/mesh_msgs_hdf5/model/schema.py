"""Schema S1: the paths, attributes and names of a map file.

Everything about one mesh is in the group of its part (usually /mesh). `channels` holds vertex data
and the faces, in two dimensions ([V,3], [F,3], [V,1]); LVR2 and mesh_map 1.x read no mesh without
the variable-length string attributes IO and CLASS on the part's group; the released hdf5_map_io
expects the other three groups, and textures, materials and labels in one dimension.
"""
from typing import List

import numpy as np

from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

VERSION = 1

CHANNELS = "channels"
LABELS = "labels"
TEXTURES = "textures"
GROUPS = (CHANNELS, "clustersets", LABELS, TEXTURES)
FACE_ATTRIBUTES = "face_attributes"  # a group of our own: name -> [F] or [F,C]
SEAMS = "seams"  # a group of our own, of a mesh with copies of vertices along seams of textures
ORIGINALS = "originals"  # in seams: <u4 [C], the vertices that the last C are copies of
PARENT_UUID = "parent_uuid"  # text, of originals: of the mesh without the copies

RAW = "raw"  # of the file, no part: sensor data, see map_file.scans

VERTICES = "vertices"
FACES = "face_indices"
NORMALS = "vertex_normals"
COLORS = "vertex_colors"

# channel -> (columns, dtype); a cost layer is any other float channel with one value per vertex
# that is not marked as an attribute; all other numbers with a row per vertex are vertex attributes
ARRAYS = {VERTICES: (3, "<f4"), FACES: (3, "<u4"), NORMALS: (3, "<f4"), COLORS: (3, "|u1")}
COST_DTYPE = "<f4"
KIND, ATTRIBUTE = "kind", "attribute"  # the mark: a string attribute of the dataset, and its value
# in channels: a group with a dataset [D] for each feature, whose attribute is the place [3]
FEATURES = "texture_features"
FEATURE_LOCATION = "vector"
# in textures
TEXTURE_COORDINATES = "coords"  # <f4 [3V]: u, v, 0 of each vertex
MATERIALS = "materials"  # MATERIAL_DTYPE [M]
FACE_MATERIALS = "mat_face_indices"  # <u4 [F]
IMAGES = "images"  # a group: index -> |u1 [height,width,3], an image of the HDF5 Image spec
MATERIAL_DTYPE = np.dtype(
    {
        "names": ["textureIndex", "r", "g", "b"],
        "formats": ["<i4", "|u1", "|u1", "|u1"],
        "offsets": [0, 4, 5, 6],
        "itemsize": 8,
    }
)
RESERVED = frozenset(ARRAYS) | {
    "edge_distances",
    "edge_distances_idx",
    "face_colors",
    "face_material_indices",
    "face_normals",
    "texture_coordinates",
    FEATURES,
}

# string attributes of the part's group: these two are LVR2's (of variable length), the others ours
# (of fixed length)
LVR2_ATTRIBUTES = {"IO": "MeshIO", "CLASS": "MeshBuffer"}
SCHEMA_VERSION = "schema_version"  # int
LVR2_PART_OF = "lvr2_part_of"  # of a part for LVR2 alone: the part that it was made of
FRAME_ID = "frame_id"
UUID = "uuid"
SOURCE = "source"  # JSON object: provenance
ORIGIN = "origin"  # <f8 [3]: vertices + origin are coordinates in CRS
CRS = "crs"  # text, e.g. EPSG:25832
PARAMETERS = "parameters"  # of the dataset of a layer or attribute: JSON object
LABEL_COLOR = "color"  # of a label's dataset: |u1 [3]

MAX_NAME_BYTES = 255
MAX_CRS = 4096  # bytes; a WKT description may be long


def part_path(path: PathLike, part: str) -> List[str]:
    """The components of a part's name; "" or "/" is the root group.

    Refuses what is no plain name.
    """
    components = list(filter(None, part.split("/")))
    for name in components:
        _check_name(path, "part", name)
    return components


def new_part_path(path: PathLike, part: str) -> List[str]:
    """The same of a part that is to be made.

    Refuses (MapFileError part) names that the file keeps for something else: of sensor data, and of
    the groups in a part.
    """
    components = part_path(path, part)
    kept = {*GROUPS, FACE_ATTRIBUTES, SEAMS}.intersection(components)
    kept.update({RAW}.intersection(components[:1]))
    for name in sorted(kept):
        what = "the scans" if name == RAW else "what belongs to a mesh"
        text = "a part cannot be called %s: the file keeps this name for %s" % (name, what)
        raise MapFileError("part", path, text, "choose another name")
    return components


def check_layer_name(path: PathLike, name: str) -> None:
    """Refuse a layer name that cannot be one in the group `channels`, or has a meaning there."""
    _check_array_name(path, "layer", name, RESERVED)


def check_vertex_attribute_name(path: PathLike, name: str) -> None:
    """Refuse a name that cannot be one beside the layers in the group `channels`."""
    _check_array_name(path, "vertex attribute", name, RESERVED)


def check_face_attribute_name(path: PathLike, name: str) -> None:
    """Refuse a name that cannot be one in the group `face_attributes`."""
    _check_array_name(path, "face attribute", name, ())


def _check_array_name(path, what, name, reserved):
    _check_name(path, what, name)
    called, hint = "%s name %r " % (what, name), "choose another name"
    if "/" in name:
        raise MapFileError("layer", path, called + "contains a slash", "use _ instead")
    if name in reserved or name.endswith("_idx"):
        raise MapFileError("layer", path, called + "is kept for mesh data", hint)


def check_frame_id(path: PathLike, frame_id: str) -> None:
    """Refuse a frame that tf2 would not accept."""
    if not frame_id or frame_id.startswith("/") or len(frame_id) > MAX_NAME_BYTES:
        reason = "is empty, starts with a slash or is too long"
    elif not frame_id.isprintable() or " " in frame_id:
        reason = "contains a blank or a control character"
    else:
        return
    raise MapFileError("frame", path, "frame %r %s" % (frame_id, reason), "for example: map")


def _check_name(path, what, name):
    try:
        size = len(name.encode("utf-8"))
    except UnicodeEncodeError:
        size = 0
    if not 0 < size <= MAX_NAME_BYTES or name in (".", "..") or not name.isprintable():
        raise MapFileError(
            "part" if what == "part" else "layer",
            path,
            "%s name %r is empty, too long, '.', '..' or not printable UTF-8" % (what, name[:80]),
            "choose another name",
        )
