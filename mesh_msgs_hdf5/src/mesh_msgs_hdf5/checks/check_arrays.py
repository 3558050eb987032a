"""Checks of single arrays of a mesh; a refusal names first index, number and way out."""
from typing import Optional

import numpy as np

from mesh_msgs_hdf5 import schema
from mesh_msgs_hdf5.checks.exact import to_exact
from mesh_msgs_hdf5.errors import MapFileError, PathLike

REPAIR = "repair the mesh where it was made"


def check_finite(path: PathLike, name: str, array: np.ndarray) -> None:
    """Refuse an (N, C) float array in which a row is not finite."""
    if np.isfinite(array).all():
        return
    rows = np.flatnonzero(~np.isfinite(array).all(axis=1))
    raise MapFileError(
        "not_finite",
        path,
        "row %d of %s is not finite (%s), %d in all" % (rows[0], name, array[rows[0]], len(rows)),
        REPAIR,
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
    wrong = _outside(faces, vertex_count)
    if wrong.any():
        rows = np.flatnonzero(wrong.any(axis=1))
        row = rows[0]
        raise MapFileError(
            "index",
            path,
            "face %d refers to vertex %d, but the mesh has %d vertices; %d faces do so"
            % (row, faces[row][wrong[row]][0], vertex_count, len(rows)),
            REPAIR,
        )


def check_indices(
    path: PathLike, what: str, indices: np.ndarray, count: int, of: str, hint: str = REPAIR
) -> None:
    """Refuse (N,) integer indices that are not from 0 to count - 1.

    what, of: for the error, "<what> <position> refers to <index>, but there are <count> <of>".
    """
    wrong = _outside(indices, count)
    if wrong.any():
        rows = np.flatnonzero(wrong)
        raise MapFileError(
            "index",
            path,
            "%s %d refers to %d, but there are %d %s; %d do so"
            % (what, rows[0], indices[rows[0]], count, of, len(rows)),
            hint,
        )


def _outside(indices, count):
    wrong = indices >= count
    if indices.dtype.kind == "i":
        wrong |= indices < 0
    return wrong


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
    """Refuse -inf in the costs (N,) called name; place: what has a cost.

    NaN is unknown, +inf lethal, and a negative cost is its maker's business.
    """
    wrong = costs == -np.inf
    if wrong.any():
        raise MapFileError(
            "value",
            path,
            "%s is -inf at %s %d, %d in all"
            % (name, place, np.flatnonzero(wrong)[0], np.count_nonzero(wrong)),
            "NaN means unknown, +inf lethal",
        )


def checked_costs(path: PathLike, name: str, costs: np.ndarray, vertex_count: int) -> np.ndarray:
    """The costs of a layer as (V,) float32."""
    name = "layer %s" % name
    costs = shaped(path, name, np.asarray(costs), 1, vertex_count)
    costs = np.ascontiguousarray(to_exact(costs, schema.COST_DTYPE, path, name))
    check_costs(path, name, costs)
    return costs
