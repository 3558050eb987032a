"""The values of a mesh, checked once when it enters: from a file, or to be saved.

Also the place of the checks of single members: check_arrays, check_annotations.
"""
import json
from typing import Any, Dict, Optional

import numpy as np

from mesh_msgs_hdf5 import schema
from mesh_msgs_hdf5.checks.check_annotations import (
    checked_face_attribute,
    checked_features,
    checked_image,
    checked_label,
    checked_materials,
    checked_texture_coordinates,
)
from mesh_msgs_hdf5.checks.check_arrays import check_faces, check_finite, checked_costs, shaped
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.errors import MapFileError, PathLike, one_line
from mesh_msgs_hdf5.mesh import Mesh


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
    face attributes that are not there, and empty ones, are left out. Raises MapFileError.
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
    attributes = {
        name: checked_face_attribute(path, name, values, len(faces))
        for name, values in mesh.face_attributes.items()
    }
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
    )


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
