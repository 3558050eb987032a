"""Arrays converted without loss, or refused with the first index."""
from typing import Any, Sequence, Tuple

import numpy as np

from mesh_msgs.checks import findings
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

# what a stored array may be made of, by the kind of array asked for
_KINDS = {"f": "fiu", "u": "iu", "i": "iu"}


def to_exact(array: np.ndarray, dtype: Any, path: PathLike, name: str) -> np.ndarray:
    """The array as dtype, byte order and width changed only where every value stays the same.

    path and name are for the error: MapFileError with code dtype.
    """
    array = np.asarray(array)
    dtype = np.dtype(dtype)
    if array.dtype == dtype:
        return array
    if array.dtype.kind not in _KINDS[dtype.kind]:
        raise MapFileError(
            "dtype",
            path,
            "%s is of type %s, not %s" % (name, array.dtype, dtype),
            "import it again",
        )
    with np.errstate(all="ignore"):
        result = array.astype(dtype)
        same = result.astype(array.dtype) == array
    if dtype.kind == "u" and array.dtype.kind == "i":
        same &= array >= 0
    if dtype.kind == "i" and array.dtype.kind == "u":
        same &= result >= 0
    if dtype.kind == "f" and array.dtype.kind in "iu":
        # what was rounded up to more than the integer holds is not defined when converted back
        same &= result < 2.0 ** (8 * array.dtype.itemsize - (array.dtype.kind == "i"))
    if array.dtype.kind == "f":
        same |= np.isnan(array)
    if not same.all():
        first = np.argwhere(~same)[0]
        raise MapFileError(
            "dtype",
            path,
            "%s is of type %s, and %d values do not fit %s, first %s at %s"
            % (
                name,
                array.dtype,
                np.count_nonzero(~same),
                dtype,
                array[tuple(first)],
                place(first),
            ),
            "convert it where it was made",
        )
    return result


def place(index: Sequence[int]) -> str:
    """'row 5, column 1' of an index (as np.argwhere gives it)."""
    names = ("row", "column") + tuple("axis %d" % i for i in range(2, len(index)))
    return ", ".join("%s %d" % pair for pair in zip(names, index))


def narrowed(array: np.ndarray, path: PathLike, name: str) -> Tuple[np.ndarray, float]:
    """float32 (N, C) of float coordinates that may be wider, refused where not finite in float32.

    Returns (array, largest change in the array's unit). MapFileError not_finite names first row and
    count.
    """
    for found in findings.check_finite(
        "not_finite", name, array, "repair the mesh where it was made"
    ):
        value = np.array2string(np.asarray(array[found.index]), separator=", ")
        what = "%s %d is not finite in float32 (%s), %d in all"
        raise MapFileError(
            found.rule, path, what % (name, found.index, value, found.count), found.hint
        )
    result = np.ascontiguousarray(findings.narrowed(array))
    change = 0.0
    if array.dtype != result.dtype and len(array):
        change = float(np.abs(result.astype(array.dtype) - array).max())
    return result, change
