"""The values of a mesh, checked once when it enters: from a file, or to be saved.

A refusal names the first index, the number of such values and the way out.
"""
import json
from typing import Any, Collection, Dict, Optional

import numpy as np

from mesh_msgs.checks import findings, geometry
from mesh_msgs.split_mesh import copies_fault
from mesh_msgs.text import one_line
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import check_label
from mesh_msgs_hdf5.model.mesh import Color, Features, Label, Materials, Mesh

REPAIR = "repair the mesh where it was made"
MAX_TEXTURE_INDEX = (1 << 31) - 1  # a material's textureIndex is an int32
MAX_FEATURES = 100_000  # each is a dataset of its own, and no group of a map may have more
_DTYPE_HINT = "convert it where it was made"
_NAMES_OF = {
    "vertex": schema.check_vertex_attribute_name,
    "face": schema.check_face_attribute_name,
}


def check_finite(path: PathLike, name: str, array: np.ndarray) -> None:
    """Refuse an (N, C) float array in which a row is not finite."""
    for found in findings.check_finite("not_finite", "row", array, REPAIR):
        raise MapFileError(
            found.rule,
            path,
            "row %d of %s is not finite (%s), %d in all"
            % (found.index, name, array[found.index], found.count),
            found.hint,
        )


def check_faces(path: PathLike, faces: np.ndarray, vertex_count: int) -> None:
    """Refuse a mesh without faces, and faces that refer to no vertex.

    Faces: (F, 3) of any integer type.
    """
    if not len(faces):
        raise MapFileError(
            "no_faces",
            path,
            "the mesh has no faces",
            "a map needs triangles: mesh the points first",
        )
    check_indices(path, "face", "vertex/vertices", faces, vertex_count)


def check_indices(
    path: PathLike, noun: str, target: str, indices: np.ndarray, count: int, hint: str = REPAIR
) -> None:
    """Refuse (N,) or (N, C) integer indices that are not from 0 to count - 1.

    noun: what refers. target: what is referred to, singular and plural: "face/faces".
    """
    for found in findings.check_indices("index", noun, target, indices, count, hint):
        raise MapFileError(found.rule, path, found.what, found.hint)


def shaped(
    path: PathLike, name: str, array: np.ndarray, columns: int, rows: Optional[int] = None
) -> np.ndarray:
    """The array as (rows, columns), or as (rows,) for one column, from rank 1 or 2.

    Refuses any other shape.
    """
    shape = array.shape
    fits = array.ndim == 1 and array.size % columns == 0 or array.ndim == 2 and shape[1] == columns
    if not fits or rows is not None and array.size != rows * columns:
        wanted = "[%s,%d]" % ("N" if rows is None else rows, columns)
        raise MapFileError(
            "shape",
            path,
            "%s has the shape %s, not %s" % (name, list(shape), wanted),
            "is it another mesh's, or in a layout of another program?",
        )
    return array.reshape(-1) if columns == 1 else array.reshape(-1, columns)


def check_costs(path: PathLike, name: str, costs: np.ndarray, place: str = "vertex") -> None:
    """Refuse -inf in the float32 costs (N,) called name; place: what has a cost.

    NaN is unknown, +inf lethal, and a negative cost is its maker's business.
    """
    for found in geometry.check_costs(costs, None, place):
        raise MapFileError(
            "value",
            path,
            "%s is -inf at %s %d, %d in all" % (name, place, found.index, found.count),
            "NaN means unknown, +inf lethal",
        )


def checked_costs(path: PathLike, name: str, costs: np.ndarray, vertex_count: int) -> np.ndarray:
    """The costs of a layer as (V,) float32."""
    name = "layer %s" % name
    costs = shaped(path, name, np.asarray(costs), 1, vertex_count)
    costs = np.ascontiguousarray(to_exact(costs, schema.COST_DTYPE, path, name))
    check_costs(path, name, costs)
    return costs


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
        check_indices(path, name + ", entry", "face/faces", faces, face_count, "label it again")
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
        check_indices(path, "face", "material/materials", faces, len(colors))
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


def checked_attribute(
    path: PathLike, place: str, name: str, values: np.ndarray, count: int
) -> np.ndarray:
    """(N,) or (N, C) numbers in their own type, little-endian; one column is (N,).

    place: "vertex" or "face", of which there are count. (F,) float32 are costs of faces: -inf is
    refused.
    """
    _NAMES_OF[place](path, name)
    what = "%s attribute %s" % (place, name)
    values = np.asarray(values)
    if values.dtype.kind not in "fiu" or values.dtype.itemsize > 8:
        raise MapFileError(
            "dtype", path, "%s is of type %s, not numbers" % (what, values.dtype), _DTYPE_HINT
        )
    if values.ndim not in (1, 2) or len(values) != count or not values.size:
        raise MapFileError(
            "shape",
            path,
            "%s has the shape %s, not [%d] or [%d,C]" % (what, list(values.shape), count, count),
            "one row for each %s" % place,
        )
    if values.shape[1:] == (1,):
        values = values.reshape(-1)
    values = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    if place == "face" and values.ndim == 1 and values.dtype == np.float32:
        check_costs(path, what, values, "face")
    return values


def check_names_apart(
    path: PathLike, layers: Collection[str], vertex_attributes: Collection[str]
) -> None:
    """Refuse a layer and a vertex attribute of one name: both are in the group `channels`."""
    both = sorted(set(layers) & set(vertex_attributes))
    if both:
        raise MapFileError(
            "layer",
            path,
            "%r is the name of a layer and of a vertex attribute, %d in all" % (both[0], len(both)),
            "delete the other one first, or choose another name",
        )


def identical(one: Optional[np.ndarray], other: Optional[np.ndarray]) -> bool:
    """True if both are None, or arrays of the same type and shape with the same bytes."""
    if one is None or other is None:
        return one is other
    if one.dtype != other.dtype or one.shape != other.shape:
        return False
    one, other = (np.ascontiguousarray(array).reshape(-1).view(np.uint8) for array in (one, other))
    return np.array_equal(one, other)


def checked_channel(
    path: PathLike, name: str, values: np.ndarray, vertex_count: Optional[int] = None
) -> np.ndarray:
    """vertices, face_indices, vertex_normals or vertex_colors in the schema's type, checked.

    vertex_count: None for the vertices themselves; the others need it.
    """
    columns, dtype = schema.ARRAYS[name]
    values = np.asarray(values)
    if name == schema.FACES:
        if values.ndim == 2 and values.shape[1] == 3 and values.dtype.kind in "iu":
            check_faces(path, values, vertex_count)  # before conversion: -1 is a wrong index
        vertices, vertex_count = vertex_count, None
    values = shaped(path, name, values, columns, vertex_count)
    values = np.ascontiguousarray(to_exact(values, dtype, path, name))
    if name == schema.FACES:
        check_faces(path, values, vertices)
    elif values.dtype.kind == "f":
        check_finite(path, name, values)
    return values


def checked_mesh(path: PathLike, mesh: Mesh) -> Mesh:
    """A Mesh whose arrays have the types and shapes of the schema and whose values are sound.

    Nothing is converted with loss; arrays that are right are not copied. Parameters of layers and
    attributes that are not there, and empty ones, are left out. Raises MapFileError.
    """
    vertices = checked_channel(path, schema.VERTICES, mesh.vertices)
    rows = len(vertices)
    faces = checked_channel(path, schema.FACES, mesh.faces, rows)
    normals, colors, uv = mesh.vertex_normals, mesh.vertex_colors, mesh.texture_coordinates
    schema.check_frame_id(path, mesh.frame_id)
    costs = {}
    for name, values in mesh.vertex_costs.items():
        schema.check_layer_name(path, name)
        costs[name] = checked_costs(path, name, values, rows)
    attributes, of_vertices = (
        {name: checked_attribute(path, place, name, values, count) for name, values in of.items()}
        for place, of, count in (
            ("face", mesh.face_attributes, len(faces)),
            ("vertex", mesh.vertex_attributes, rows),
        )
    )
    check_names_apart(path, costs, of_vertices)
    textures = {
        int(index): checked_image(path, index, image) for index, image in mesh.textures.items()
    }
    materials, features = mesh.materials, mesh.features
    if materials is not None:
        materials = checked_materials(path, materials, len(faces), textures)
    return Mesh(
        vertices=vertices,
        faces=faces,
        vertex_normals=(
            None if normals is None else checked_channel(path, schema.NORMALS, normals, rows)
        ),
        vertex_colors=(
            None if colors is None else checked_channel(path, schema.COLORS, colors, rows)
        ),
        vertex_costs=costs,
        frame_id=mesh.frame_id,
        source=checked_object(path, schema.SOURCE, mesh.source),
        layer_parameters=_checked_parameters(path, "layer", mesh.layer_parameters, costs),
        face_attributes=attributes,
        face_parameters=_checked_parameters(
            path, "face attribute", mesh.face_parameters, attributes
        ),
        vertex_attributes=of_vertices,
        vertex_parameters=_checked_parameters(
            path, "vertex attribute", mesh.vertex_parameters, of_vertices
        ),
        texture_coordinates=None if uv is None else checked_texture_coordinates(path, uv, rows),
        textures=textures,
        materials=materials,
        labels={
            text: checked_label(path, text, label, len(faces))
            for text, label in mesh.labels.items()
        },
        features=None if features is None else checked_features(path, features),
        origin=checked_origin(path, mesh.origin),
        crs=checked_crs(path, mesh.crs),
        seam_originals=None if mesh.seam_originals is None else checked_seams(path, mesh),
    )


def checked_seams(path: PathLike, mesh: Mesh) -> np.ndarray:
    """(C,) uint32: which vertices of a mesh are copies of which, if that is so."""
    name = "%s/%s" % (schema.SEAMS, schema.ORIGINALS)
    originals = to_exact(np.asarray(mesh.seam_originals), "<u4", path, name)
    fault = copies_fault(mesh.vertices, originals)
    if fault is not None:
        raise MapFileError("index", path, "%s: %s" % (name, fault), "without it the mesh is sound")
    return originals


def _checked_parameters(path, what, parameters, members):
    return {
        name: checked_object(path, "the parameters of %s %s" % (what, name), value)
        for name, value in parameters.items()
        if name in members and value
    }


def checked_object(path: PathLike, name: str, value: Any) -> Dict[str, Any]:
    """The dict as it is, if it can be stored as a JSON object."""
    if not isinstance(value, dict):
        raise MapFileError("value", path, "%s is no dict" % name, "give names and values")
    to_json(path, name, value)
    return value


def checked_origin(path: PathLike, origin: Any) -> Any:
    """The origin as three finite floats."""
    try:
        values = np.asarray(origin, dtype=np.float64)
        sound = values.shape == (3,) and np.isfinite(values).all()
    except (TypeError, ValueError):
        sound = False
    if not sound:
        raise MapFileError(
            "value",
            path,
            "the origin %s is not three finite numbers" % one_line(repr(origin))[:80],
            "x, y and z in meters",
        )
    return tuple(float(value) for value in values)


def checked_crs(path: PathLike, crs: Any) -> str:
    """The name of a coordinate reference system as it is; may be empty."""
    if isinstance(crs, str) and crs.isprintable() and len(crs.encode("utf-8")) <= schema.MAX_CRS:
        return crs
    raise MapFileError(
        "value",
        path,
        "crs %s is no printable text of at most %d bytes"
        % (one_line(repr(crs))[:80], schema.MAX_CRS),
        "for example: EPSG:25832",
    )


def to_json(path: PathLike, name: str, value: Any) -> str:
    """The text of a dict for an attribute; NumPy values are allowed."""
    try:
        return json.dumps(value, sort_keys=True, default=_plain)
    except (TypeError, ValueError, RecursionError) as error:
        raise MapFileError(
            "value",
            path,
            "%s cannot be stored: %s" % (name, error),
            "numbers, texts, lists and dicts can",
        ) from error


def from_json(path: PathLike, name: str, text: Optional[str]) -> Dict[str, Any]:
    """The dict of an attribute's text ({} of None)."""
    try:
        value = json.loads(text) if text is not None else {}
    except (TypeError, ValueError, RecursionError) as error:
        raise MapFileError("value", path, "%s is not JSON: %s" % (name, error), "") from error
    if not isinstance(value, dict):
        raise MapFileError("value", path, "%s is not a JSON object" % name, "")
    return value


def _plain(value):
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError("%s is no number, text, list or dict" % type(value).__name__)
