"""A message member that is a NumPy array laid over the wire."""

from typing import Any, Optional, Sequence, Tuple

import genpy
import numpy as np

from mesh_msgs.wire.framing import ArrayError, Parts, Reader, pack_count


def array_of(sequence: Any, attributes: Tuple[str, ...] = ()) -> np.ndarray:
    """A list of numbers, rows, or message objects as an array, without a check of its shape.

    Args:
        sequence: numbers, rows of numbers, or genpy messages.
        attributes: members of each message object that make up its row, e.g. ("x", "y", "z"). A
            single one is a member that is a row itself.
    Raises:
        ValueError, TypeError, AttributeError: rows of unequal length, or objects of another type.
    """
    if isinstance(sequence, np.ndarray):
        return np.asarray(sequence)
    if attributes and isinstance(sequence, (list, tuple)) and sequence:
        if isinstance(sequence[0], genpy.Message):
            if len(attributes) == 1:
                return np.array([getattr(item, attributes[0]) for item in sequence])
            return np.array([[getattr(item, name) for name in attributes] for item in sequence])
    return np.asarray(sequence)


class ConvertedOnWrite:
    """Numbers that are converted to the type on the wire in small pieces, which stay in the cache.

    Converting a geometry of a million vertices as a whole takes half as long again.
    """

    _PIECE = 1 << 17  # numbers

    def __init__(self, flat: np.ndarray, dtype: np.dtype) -> None:
        self._flat = flat
        self._dtype = dtype

    def write_to(self, buff: Any) -> None:
        """Writes the numbers to a file-like object."""
        if self._flat.dtype == self._dtype:
            buff.write(self._flat.view(np.uint8).data)
            return
        for start in range(0, len(self._flat), self._PIECE):
            piece = self._flat[start : start + self._PIECE].astype(self._dtype)
            buff.write(piece.view(np.uint8).data)


class ArrayField:
    """Member `name` of a message as an array of shape (N,) or (N, columns).

    Arrays of a type that can be written without loss are kept as they are, not copied; a list of
    numbers or of message objects, and an array of another type, becomes a new array when it is
    assigned.

    Args:
        name: member of the generated class.
        dtype: little-endian type on the wire, "<f8", "<f4" or "<u4".
        columns: numbers of a row, None for a flat array.
        attributes: see array_of; used for lists of message objects.
    """

    def __init__(
        self, name: str, dtype: str, columns: Optional[int] = None, attributes: Sequence[str] = ()
    ) -> None:
        self.name = name
        self.dtype = np.dtype(dtype)
        self.columns = columns
        self.attributes = tuple(attributes)
        self.item_size = self.dtype.itemsize * (columns or 1)
        # float32 widens to float64 without loss: keeping it halves the memory of a geometry.
        self.kept = (self.dtype, np.dtype("<f4")) if dtype == "<f8" else (self.dtype,)

    def normalize(self, value: Any) -> Optional[np.ndarray]:
        """The array to be stored for an assigned value. None (genpy's "not given") stays None."""
        if value is None:
            return None
        try:
            array = array_of(value, self.attributes)
        except (ValueError, TypeError, AttributeError) as error:
            raise ArrayError(
                "%s: expected an array of shape %s: %s" % (self.name, self._shape(), error)
            ) from error
        if array.shape == (0,):
            array = np.zeros(self._empty_shape(), self.dtype)
        self._check_shape(array)
        if array.dtype in self.kept:
            return array
        return self._to_integers(array) if self.dtype.kind == "u" else self._to_floats(array)

    def write(self, value: Any, parts: Parts) -> None:
        """Appends length and content."""
        if not isinstance(value, np.ndarray):
            raise ArrayError("%s: is %r, not an array" % (self.name, value))
        self._check_shape(value)  # the owner of the array may have reshaped it since
        parts.append(pack_count(self.name, len(value)))
        if value.size:
            parts.append(ConvertedOnWrite(np.ascontiguousarray(value).reshape(-1), self.dtype))

    def read(self, reader: Reader) -> np.ndarray:
        """A read-only view of the buffer, aligned or not: it starts wherever its bytes do."""
        count = reader.count(self.name, self.item_size)
        start = reader.take(self.name, count * self.item_size)
        if not count:
            array = np.zeros(self._empty_shape(), self.dtype)
            array.flags.writeable = False
            return array
        array = np.frombuffer(reader.buffer, self.dtype, count * (self.columns or 1), start)
        return array if self.columns is None else array.reshape(count, self.columns)

    @staticmethod
    def equal(left: Any, right: Any) -> bool:
        """Same shape and values. NaN equals NaN: unknown costs make no difference."""
        if left is None or right is None:
            return left is right
        if left.shape != right.shape:
            return False
        return bool(np.all((left == right) | ((left != left) & (right != right))))

    def summary(self, value: Any) -> str:
        """Type and shape instead of the numbers."""
        return "None" if value is None else "%s %s" % (value.dtype.name, value.shape)

    def _shape(self) -> str:
        return "(N,)" if self.columns is None else "(N, %d)" % self.columns

    def _empty_shape(self) -> Tuple[int, ...]:
        return (0,) if self.columns is None else (0, self.columns)

    def _check_shape(self, array: np.ndarray) -> None:
        if array.ndim == len(self._empty_shape()) and array.shape[1:] == self._empty_shape()[1:]:
            return
        raise ArrayError("%s: expected shape %s, got %s" % (self.name, self._shape(), array.shape))

    def _to_floats(self, array: np.ndarray) -> np.ndarray:
        if array.dtype.kind not in "fiu":
            raise ArrayError("%s: expected numbers, got type %s" % (self.name, array.dtype))
        with np.errstate(over="ignore"):
            narrowed = array.astype(self.dtype)
        lost = np.isinf(narrowed) & ~np.isinf(array)
        if lost.any():
            self._refuse(array, lost, "does not fit into %s" % self.dtype.name)
        return narrowed

    def _to_integers(self, array: np.ndarray) -> np.ndarray:
        if array.size == 0:
            return array.astype(self.dtype)
        if array.dtype.kind not in "iu":
            raise ArrayError("%s: expected integers, got type %s" % (self.name, array.dtype))
        limit = np.iinfo(self.dtype).max
        if int(array.min()) < 0 or int(array.max()) > limit:
            self._refuse(array, (array < 0) | (array > limit), "is not between 0 and %d" % limit)
        return array.astype(self.dtype)

    def _refuse(self, array: np.ndarray, bad: np.ndarray, reason: str) -> None:
        first = tuple(int(i) for i in np.argwhere(bad)[0])
        index = ", ".join(str(i) for i in first)
        raise ArrayError(
            "%s[%s] = %s %s (%d such values)"
            % (self.name, index, array[first], reason, np.count_nonzero(bad))
        )
