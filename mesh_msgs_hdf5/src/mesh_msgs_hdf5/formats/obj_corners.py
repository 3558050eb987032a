"""The corners of the faces of an OBJ file: numbers from text, and indices from numbers."""
import numpy as np

from mesh_msgs_hdf5.errors import MapFileError, PathLike, one_line
from mesh_msgs_hdf5.formats.numbers_text import numbers

_SLASH, _BLANK, _NEWLINE = ord("/"), 32, 10


def corner_numbers(path: PathLike, text: bytes, counts: np.ndarray, first: int) -> np.ndarray:
    """(N, 3) whole numbers of the corners: vertex, texture coordinates, normal; 0 if there is none.

    text: corners like 1, 1/2, 1//3 or 1/2/3 with blanks between; counts: corners of each face;
    first: the number of the first face, for the error.
    """
    found = _found(path, text, counts, first)
    small = not len(found) or max(-found.min(), found.max()) < 1 << 31
    return found.astype(np.int32) if small else found


def _found(path, text, counts, first):
    total = int(counts.sum())
    found = np.zeros((total, 3), np.int64)
    slashes = text.count(b"/")
    if not slashes:
        found[:, 0] = numbers(path, text, "faces", np.int64, before=first)
        return found
    if slashes == _same_slashes(text, total) * total:
        # all corners have the same form, or one has too few numbers: then they are not enough
        doubled = text.count(b"//")
        columns = {(1, 0): [0, 1], (2, 0): [0, 1, 2], (2, total): [0, 2]}.get(
            (slashes // total, doubled)
        )
        if columns is not None:
            flat = numbers(path, text.replace(b"/", b" "), "faces", np.int64, before=first)
            if len(flat) == total * len(columns):
                found[:, columns] = flat.reshape(-1, len(columns))
                return found
    return _one_by_one(path, text, counts, found, first)


def _same_slashes(text, total):
    """How many slashes each corner has, or 0 if they differ."""
    letters = np.frombuffer(text, np.uint8)
    in_word = (letters != _BLANK) & (letters != _NEWLINE)
    begins = in_word.copy()
    begins[1:] &= ~in_word[:-1]
    places = np.flatnonzero(begins)
    number = np.add.reduceat(letters == _SLASH, places, dtype=np.int64)
    return int(number[0]) if len(places) == total and (number == number[0]).all() else 0


def _one_by_one(path, text, counts, found, first):
    for i, word in enumerate(text.split()):
        parts = word.split(b"/")
        try:
            if len(parts) > 3:
                raise ValueError
            for column, part in enumerate(parts):
                if part or column == 0:
                    found[i, column] = int(part)
        except (ValueError, OverflowError) as error:
            face = first + int(np.searchsorted(np.cumsum(counts), i, side="right"))
            raise MapFileError(
                "format",
                path,
                "face %d has a corner that is none: %s" % (face, one_line(repr(word[:40])[1:])),
                "is the file damaged?",
            ) from error
    return found


def from_zero(written: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Indices from 0 of OBJ's numbers (N,): from 1, or negative from the last one before the face.

    last: (N,) how many stood before the face. 0 becomes -1: no index.
    """
    if (written >= 0).all():
        return written - 1
    return np.where(written > 0, written - 1, np.where(written < 0, last + written, -1))
