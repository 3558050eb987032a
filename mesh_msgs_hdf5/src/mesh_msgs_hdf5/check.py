"""The values of a mesh, checked once when it enters: from a file, or to be saved."""
import json
from typing import Any, Dict, Optional

import numpy as np

from mesh_msgs_hdf5 import schema
from mesh_msgs_hdf5.errors import MapFileError, PathLike
from mesh_msgs_hdf5.exact import to_exact
from mesh_msgs_hdf5.mesh import Mesh

_REPAIR = "repair the mesh where it was made"


def identical(one: Optional[np.ndarray], other: Optional[np.ndarray]) -> bool:
    """True if both are None, or arrays of the same type and shape with the same bytes."""
    if one is None or other is None:
        return one is other
    if one.dtype != other.dtype or one.shape != other.shape:
        return False
    one, other = (np.ascontiguousarray(array).reshape(-1).view(np.uint8) for array in (one, other))
    return np.array_equal(one, other)


def check_finite(path: PathLike, name: str, array: np.ndarray) -> None:
    """Refuse an (N, C) float array in which a row is not finite."""
    if np.isfinite(array).all():
        return
    rows = np.flatnonzero(~np.isfinite(array).all(axis=1))
    raise MapFileError(
        "not_finite",
        path,
        "row %d of %s is not finite (%s), %d in all" % (rows[0], name, array[rows[0]], len(rows)),
        _REPAIR,
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
    wrong = faces >= vertex_count
    if faces.dtype.kind == "i":
        wrong |= faces < 0
    if wrong.any():
        rows = np.flatnonzero(wrong.any(axis=1))
        row = rows[0]
        raise MapFileError(
            "index",
            path,
            "face %d refers to vertex %d, but the mesh has %d vertices; %d faces do so"
            % (row, faces[row][wrong[row]][0], vertex_count, len(rows)),
            _REPAIR,
        )


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


def check_costs(path: PathLike, name: str, costs: np.ndarray) -> None:
    """Refuse -inf in a layer.

    NaN is unknown, +inf lethal, and a negative cost is its maker's business.
    """
    wrong = costs == -np.inf
    if wrong.any():
        raise MapFileError(
            "value",
            path,
            "layer %s is -inf at vertex %d, %d in all"
            % (name, np.flatnonzero(wrong)[0], np.count_nonzero(wrong)),
            "NaN means unknown, +inf lethal",
        )


def checked_costs(path: PathLike, name: str, costs: np.ndarray, vertex_count: int) -> np.ndarray:
    """The costs of a layer as (V,) float32."""
    costs = shaped(path, "layer %s" % name, np.asarray(costs), 1, vertex_count)
    costs = np.ascontiguousarray(to_exact(costs, schema.COST_DTYPE, path, "layer %s" % name))
    check_costs(path, name, costs)
    return costs


def checked_mesh(path: PathLike, mesh: Mesh) -> Mesh:
    """A Mesh whose arrays have the types and shapes of the schema and whose values are sound.

    Nothing is converted with loss. Raises MapFileError.
    """

    def array(name, values, rows=None):
        columns, dtype = schema.ARRAYS[name]
        values = to_exact(shaped(path, name, np.asarray(values), columns, rows), dtype, path, name)
        return np.ascontiguousarray(values)

    vertices = array(schema.VERTICES, mesh.vertices)
    check_finite(path, schema.VERTICES, vertices)
    faces = np.asarray(mesh.faces)
    if faces.ndim == 2 and faces.shape[1] == 3 and faces.dtype.kind in "iu":
        check_faces(path, faces, len(vertices))  # before conversion: -1 is a wrong index
    faces = array(schema.FACES, faces)
    check_faces(path, faces, len(vertices))
    normals, colors = mesh.vertex_normals, mesh.vertex_colors
    if normals is not None:
        normals = array(schema.NORMALS, normals, len(vertices))
        check_finite(path, schema.NORMALS, normals)
    if colors is not None:
        colors = array(schema.COLORS, colors, len(vertices))
    schema.check_frame_id(path, mesh.frame_id)
    costs = {}
    for name, values in mesh.vertex_costs.items():
        schema.check_layer_name(path, name)
        costs[name] = checked_costs(path, name, values, len(vertices))
    return Mesh(
        vertices=vertices,
        faces=faces,
        vertex_normals=normals,
        vertex_colors=colors,
        vertex_costs=costs,
        frame_id=mesh.frame_id,
        source=mesh.source,
        layer_parameters={k: v for k, v in mesh.layer_parameters.items() if k in costs},
    )


def to_json(path: PathLike, name: str, value: Any) -> str:
    """The text of a dict for an attribute; NumPy values are allowed."""
    try:
        return json.dumps(value, sort_keys=True, default=_plain)
    except (TypeError, ValueError) as error:
        raise MapFileError("value", path, "%s cannot be stored: %s" % (name, error), "") from error


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
