"""Numbers from text, vectorized and whatever the locale."""
import warnings
from typing import Any

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike


def numbers(
    path: PathLike, text: bytes, what: str, dtype: Any = np.float64, before: int = 0
) -> np.ndarray:
    """All numbers of a bytes text with blanks between.

    MapFileError format names the first word that is none; before: how many stood before the text.
    """
    if not text.strip():
        return np.zeros(0, dtype)
    with warnings.catch_warnings():
        # this warning alone: other threads' warnings pass through the same filters
        warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
        try:
            return np.fromstring(text, dtype=dtype, sep=" ")
        except (DeprecationWarning, ValueError):
            pass
    convert = float if np.dtype(dtype).kind == "f" else int
    for index, word in enumerate(text.split()):
        try:
            convert(word)
        except ValueError:
            break
    else:
        word, index = b"?", 0
    raise MapFileError(
        "format",
        path,
        "%s: value %d is no number: %s" % (what, before + index, one_line(repr(word[:40])[1:])),
        "is the file damaged?",
    )
