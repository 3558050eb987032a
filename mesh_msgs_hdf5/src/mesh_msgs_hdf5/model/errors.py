"""The one error of this package."""
import os
from typing import Union

from mesh_msgs.text import one_line

PathLike = Union[str, bytes, os.PathLike]
MAX_SHOWN_PATH = 400  # characters of a path in an error


class MapFileError(Exception):
    """A file that cannot be read as a mesh, or a map that cannot be saved.

    Attributes:
        code: one word for programs:
            missing, directory, not_regular, permission, name, empty, lfs_pointer, unreadable: the
                file itself;
            format, truncated, damaged: its bytes;
            part, no_mesh, link, external, virtual, filter, size, dtype, shape, layer, label: what
                is in an HDF5 file;
            index, not_finite, rounded, no_faces, uuid, frame, value: the values of a mesh;
            exists, changed, version, schema (only read), save: writing.
            locked: another program has the file open to write; it may be read later.
            crashed, timeout: the process in which a file was read.
            journal, owned: the labels beside a map.
        path: the file (str).
        message: what is wrong, where (first index) and how many.
        hint: the way out; may be empty.
    """

    def __init__(self, code: str, path: PathLike, message: str, hint: str = "") -> None:
        super().__init__(code, path, message, hint)
        self.code = code
        self.path = os.fsdecode(path)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        hint = " (%s)" % self.hint if self.hint else ""
        return "%s: %s" % (shown_path(self.path), one_line(self.message + hint))


def shown_path(path: str) -> str:
    """A path on one line; of a very long one, what it begins and ends with."""
    text = one_line(path)
    if len(text) <= MAX_SHOWN_PATH:
        return text
    half = MAX_SHOWN_PATH // 2 - 20
    return "%s[... %d characters ...]%s" % (text[:half], len(text) - 2 * half, text[-half:])
