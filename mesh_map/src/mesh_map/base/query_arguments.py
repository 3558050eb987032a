"""Arguments of geometric queries, checked and in the form that the kernels take.

What is refused here are mistakes of a caller (ValueError). Numbers that are not finite are none:
they make a query find nothing.
"""

import math
from typing import Any, NamedTuple, Optional, Sequence

import numpy as np

_SHOWN = 100  # characters of a value in an error
_MAX_THREADS = 0xFFFFFFFF


def _shown(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= _SHOWN else text[:_SHOWN] + " ..."


def float_array(values: Any, name: str, shape: Sequence[Optional[int]]) -> np.ndarray:
    """A float64 array in C order; a copy only where that is needed.

    Args:
        values: anything array-like.
        name: for errors.
        shape: with None for any length.
    Raises:
        ValueError: no numbers, or of another shape.
    """
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ValueError("%s has rows of different lengths: %s" % (name, _shown(values))) from error
    if array.size == 0 and array.ndim == 1 and shape[0] is None:
        array = np.zeros([length or 0 for length in shape])
    if array.dtype.kind not in "fiu":
        raise ValueError("%s has to be numbers, not %s" % (name, _shown(values)))
    fits = array.ndim == len(shape) and all(
        wanted in (None, length) for wanted, length in zip(shape, array.shape)
    )
    if not fits:
        wanted = ", ".join("N" if length is None else str(length) for length in shape)
        raise ValueError("%s has to have the shape (%s), not %s" % (name, wanted, array.shape))
    return np.ascontiguousarray(array, np.float64)


def number(value: Any, name: str) -> float:
    """ValueError for anything but a number."""
    if not isinstance(value, (str, bytes)):
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    raise ValueError("%s has to be a number, not %s" % (name, _shown(value)))


def whole_number(value: Any, name: str, most: int = (1 << 63) - 1, least: str = "0") -> int:
    """ValueError for anything but a whole number from 0 (which `least` is for, in errors) on."""
    if not isinstance(value, (int, np.integer)) or not 0 <= value <= most:
        raise ValueError(
            "%s has to be a whole number, %s to %d, not %s" % (name, least, most, _shown(value))
        )
    return int(value)


def thread_count(value: Any) -> int:
    """ValueError for anything but a number of threads."""
    return whole_number(value, "threads", _MAX_THREADS, "0 (all cores)")


def one_each(array: np.ndarray, name: str, count: int, noun: str) -> np.ndarray:
    """The array as it is; ValueError where it has not one number for each of so many things."""
    if array.shape != (count,):
        raise ValueError(
            "%s has to have the shape (%d,), one for each %s, not %s"
            % (name, count, noun, array.shape)
        )
    return array


def points_array(values: Any, name: str) -> np.ndarray:
    """(N, 3) float64."""
    return float_array(values, name, (None, 3))


def vector(values: Any, name: str) -> np.ndarray:
    """(3,) float64."""
    return float_array(values, name, (3,))


def per_item(values: Any, name: str, count: int) -> np.ndarray:
    """(N, 3) float64, or (1, 3) for all N.

    Args:
        values: (N, 3), or (3,) or (1, 3) for all.
    """
    array = np.asarray(values)
    array = points_array(array[None] if array.shape == (3,) else values, name)
    if len(array) not in (1, count):
        raise ValueError(
            "%s has %d rows for %d queries: one for each is needed, or one for all"
            % (name, len(array), count)
        )
    return array


def checked_distance(value: Any) -> float:
    """A maximum distance that is not negative.

    Raises:
        ValueError: it is negative, NaN or no number.
    """
    distance = number(value, "the maximum distance")
    if not distance >= 0.0:
        raise ValueError("the maximum distance has to be 0 or more, not %g" % distance)
    return distance


def mask_array(mask: Any, face_count: int) -> Optional[np.ndarray]:
    """(F,) uint8, or None where all faces count.

    Args:
        mask: (F,) bool, or None.
        face_count: F.
    Raises:
        ValueError: another type or length.
    """
    if mask is None:
        return None
    array = np.asarray(mask)
    if array.dtype != np.bool_:
        raise ValueError(
            "mask has to be an array of bool, not of %s: True for each face that counts, such as"
            " by mask = numpy.zeros(%d, bool); mask[faces] = True" % (array.dtype, face_count)
        )
    return np.ascontiguousarray(one_each(array, "mask", face_count, "face")).view(np.uint8)


def choice(value: Any, name: str, allowed: Sequence[str]) -> str:
    """One of some words; ValueError for any other."""
    if value not in allowed:
        raise ValueError("%s has to be %s, not %s" % (name, " or ".join(allowed), _shown(value)))
    return str(value)


class NormalLimit(NamedTuple):
    """Which normals count: (N, 3) or (1, 3) float64 or None, and radians."""

    normals: Optional[np.ndarray]
    max_angle: float


def normal_limit(normal: Any, max_angle: Any, count: int, name: str) -> NormalLimit:
    """Checked limit for the normals of faces; both are given or none is.

    Raises:
        ValueError: one of both is missing, of another shape, or an angle that is not 0 to pi.
    """
    if (normal is None) != (max_angle is None):
        raise ValueError("%s and max_angle belong together: give both or none" % name)
    if normal is None:
        return NormalLimit(None, math.pi)
    angle = number(max_angle, "max_angle")
    if not 0.0 <= angle <= math.pi:
        raise ValueError("max_angle has to be 0 to pi radians, not %g" % angle)
    return NormalLimit(per_item(normal, name, count), angle)


class Rays(NamedTuple):
    """N rays in the form that the kernels take, float64 each.

    origins: (N, 3), or (1, 3) for all.
    directions: (N, 3).
    max_distances: (N,), or (1,) for all.
    """

    origins: np.ndarray
    directions: np.ndarray
    max_distances: np.ndarray

    @property
    def count(self) -> int:
        return len(self.directions)

    def part(self, begin: int, end: Optional[int] = None) -> "Rays":
        """Those from begin to before end."""
        cut = slice(begin, end)
        return Rays(
            self.origins if len(self.origins) == 1 else self.origins[cut],
            self.directions[cut],
            self.max_distances if len(self.max_distances) == 1 else self.max_distances[cut],
        )


def checked_rays(origins: Any, directions: Any, max_distance: Any) -> Rays:
    """Rays of arguments.

    Args:
        origins: (N, 3), or (3,) for all.
        directions: (N, 3).
        max_distance: (N,), or a number for all.
    Raises:
        ValueError: of another shape.
    """
    ways = points_array(directions, "directions")
    limits = np.asarray(max_distance)
    if limits.shape in ((), (1,)):
        limits = float_array(limits.reshape(1), "max_distance", (1,))
    else:
        limits = float_array(limits, "max_distance", (len(ways),))
    return Rays(per_item(origins, "origins", len(ways)), ways, limits)
