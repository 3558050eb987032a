"""Checks of what a mesh has besides its geometry: labels, textures, features and so on."""
from typing import Any, Collection, Optional

import numpy as np

from mesh_msgs_hdf5 import schema
from mesh_msgs_hdf5.checks.check_arrays import check_costs, check_finite, check_indices, shaped
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.errors import MapFileError, PathLike, one_line
from mesh_msgs_hdf5.label_names import check_label
from mesh_msgs_hdf5.mesh import Color, Features, Label, Materials

MAX_TEXTURE_INDEX = (1 << 31) - 1  # a material's textureIndex is an int32
MAX_FEATURES = 100_000  # each is a dataset of its own, and no group of a map may have more
_DTYPE_HINT = "convert it where it was made"


def checked_label(path: PathLike, text: str, label: Label, face_count: int) -> Label:
    """A Label with faces (K,) uint32 below face_count, each once (the first is kept), and a color
    of three ints from 0 to 255, or None.
    """
    check_label(path, text)
    name = "label %s" % text
    faces = np.asarray(label.faces)
    if not faces.size:  # an empty list has no type
        faces = faces.astype(np.uint32)
    faces = shaped(path, name, faces, 1)
    if faces.dtype.kind in "iu":  # before conversion: -1 is a wrong index
        check_indices(path, "entry", faces, face_count, "faces (%s)" % name, "label it again")
    faces = np.ascontiguousarray(to_exact(faces, "<u4", path, name))
    if faces.size and not (faces[1:] > faces[:-1]).all():
        firsts = np.unique(faces, return_index=True)[1]
        if len(firsts) < len(faces):
            faces = faces[np.sort(firsts)]
    return Label(faces, _checked_color(path, name, label.color))


def _checked_color(path, name, color: Any) -> Optional[Color]:
    if color is None:
        return None
    values = np.asarray(color)
    if (
        values.shape != (3,)
        or values.dtype.kind not in "iu"
        or ((values < 0) | (values > 255)).any()
    ):
        raise MapFileError(
            "value",
            path,
            "the color of %s is %s" % (name, one_line(repr(color))[:80]),
            "red, green and blue are whole numbers from 0 to 255",
        )
    return tuple(int(value) for value in values)  # type: ignore[return-value]


def checked_image(path: PathLike, index: int, image: np.ndarray) -> np.ndarray:
    """The texture as (height, width, 3 or 4) uint8."""
    whole = isinstance(index, (int, np.integer)) and not isinstance(index, bool)
    if not whole or not 0 <= index <= MAX_TEXTURE_INDEX:
        raise MapFileError(
            "index",
            path,
            "a texture has the index %s" % one_line(repr(index))[:80],
            "textures are counted from 0",
        )
    image = np.asarray(image)
    if image.ndim != 3 or image.shape[2] not in (3, 4) or not image.size:
        raise MapFileError(
            "shape",
            path,
            "texture %d has the shape %s, not [height,width,3]" % (index, list(image.shape)),
            "red, green and blue (and alpha, as a fourth) of each pixel",
        )
    return np.ascontiguousarray(to_exact(image, "|u1", path, "texture %d" % index))


def checked_materials(
    path: PathLike, materials: Materials, face_count: int, texture_indices: Collection[int]
) -> Materials:
    """Materials whose textures are among texture_indices (or -1: none), one for each face."""
    colors = shaped(path, "the colors of materials", np.asarray(materials.colors), 3)
    colors = np.ascontiguousarray(to_exact(colors, "|u1", path, "the colors of materials"))
    name = "the texture indices of materials"
    indices = shaped(path, name, np.asarray(materials.texture_indices), 1, len(colors))
    indices = np.ascontiguousarray(to_exact(indices, "<i4", path, name))
    known = np.array(sorted(texture_indices), dtype=np.int64)
    wrong = ~np.isin(indices, np.append(known, -1))
    if wrong.any():
        rows = np.flatnonzero(wrong)
        raise MapFileError(
            "index",
            path,
            "material %d has the texture %d, which is not there; %d materials do so"
            % (rows[0], indices[rows[0]], len(rows)),
            "textures: %s; -1 means none" % (", ".join(map(str, known[:10])) or "none"),
        )
    name = "the materials of faces"
    faces = shaped(path, name, np.asarray(materials.face_materials), 1, face_count)
    if faces.dtype.kind in "iu":
        check_indices(path, "the material of face", faces, len(colors), "materials")
    faces = np.ascontiguousarray(to_exact(faces, "<u4", path, name))
    return Materials(colors, indices, faces)


def checked_texture_coordinates(path: PathLike, uv: np.ndarray, vertex_count: int) -> np.ndarray:
    """(V, 2) float32, finite."""
    name = "texture coordinates"
    uv = shaped(path, name, np.asarray(uv), 2, vertex_count)
    uv = np.ascontiguousarray(to_exact(uv, "<f4", path, name))
    check_finite(path, name, uv)
    return uv


def checked_features(path: PathLike, features: Features) -> Optional[Features]:
    """Features with finite float32 locations (N, 3) and descriptors (N, D); None if N is 0, which
    is what a file says of no features.
    """
    locations = shaped(path, "the locations of features", np.asarray(features.locations), 3)
    descriptors = np.asarray(features.descriptors)
    if descriptors.ndim != 2 or len(descriptors) != len(locations):
        raise MapFileError(
            "shape",
            path,
            "the descriptors of %d features have the shape %s, not [%d,D]"
            % (len(locations), list(descriptors.shape), len(locations)),
            "one row for each location",
        )
    if len(locations) > MAX_FEATURES:
        raise MapFileError(
            "size",
            path,
            "there are %d features, more than the %d allowed" % (len(locations), MAX_FEATURES),
            "keep the strongest",
        )
    if not len(locations):
        return None
    arrays = []
    for name, values in (("locations", locations), ("descriptors", descriptors)):
        name = "the %s of features" % name
        values = np.ascontiguousarray(to_exact(values, "<f4", path, name))
        check_finite(path, name, values)
        arrays.append(values)
    return Features(*arrays)


def checked_face_attribute(
    path: PathLike, name: str, values: np.ndarray, face_count: int
) -> np.ndarray:
    """(F,) or (F, C) numbers in their own type, little-endian; one column is (F,).

    (F,) float32 are costs of faces: -inf is refused.
    """
    schema.check_face_attribute_name(path, name)
    what = "face attribute %s" % name
    values = np.asarray(values)
    if values.dtype.kind not in "fiu" or values.dtype.itemsize > 8:
        raise MapFileError(
            "dtype", path, "%s is of type %s, not numbers" % (what, values.dtype), _DTYPE_HINT
        )
    if values.ndim not in (1, 2) or len(values) != face_count or not values.size:
        raise MapFileError(
            "shape",
            path,
            "%s has the shape %s, not [%d] or [%d,C]"
            % (what, list(values.shape), face_count, face_count),
            "one row for each face",
        )
    if values.shape[1:] == (1,):
        values = values.reshape(-1)
    values = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    if values.ndim == 1 and values.dtype == np.float32:
        check_costs(path, what, values, "face")
    return values
