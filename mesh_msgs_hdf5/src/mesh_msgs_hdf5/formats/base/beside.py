"""Files that a mesh file names: only those in its folder and below are ever opened."""
import contextlib
import os
import stat
from typing import List, Optional, Tuple, Union

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import PathLike

# named files, by what they may hold at most
MAX_BYTES = 1 << 30


class Folder:
    """The folder of a mesh file."""

    def __init__(self, path: PathLike) -> None:
        self.place = os.path.dirname(os.path.realpath(os.fsdecode(path)))

    def find(self, name: Union[str, bytes]) -> Tuple[Optional[str], str]:
        """(real path of the file that a mesh file names, "") or (None, why it is not taken).

        Backslashes separate folders, too; what is no UTF-8 is tried as Latin-1. A path that leads
        elsewhere is looked for by its last part: other people's absolute paths are rarely ours.
        """
        texts = [text.strip().strip('"').replace("\\", "/") for text in _decoded(name)]
        if not texts[0] or "\0" in texts[0]:
            return None, "has no name"
        candidates = [each for text in texts for each in (text, text.rsplit("/", 1)[-1])]
        for candidate in candidates:
            found = os.path.realpath(os.path.join(self.place, candidate))
            if self._holds(found) and os.path.isfile(found):
                return found, ""
        for candidate in candidates:
            like = self._differing_in_case(candidate)
            if like is not None:
                return None, "is not there, but %s is: name it so" % shown(like)
        if self._holds(os.path.realpath(os.path.join(self.place, texts[0]))):
            return None, "is not there"
        return None, "is outside the folder of the mesh, where nothing is read"

    def _differing_in_case(self, candidate: str) -> Optional[str]:
        """The name of a file that other systems take for the candidate."""
        folder, name = os.path.split(os.path.realpath(os.path.join(self.place, candidate)))
        if not self._holds(folder + "/"):
            return None
        with contextlib.suppress(OSError):
            for each in sorted(os.listdir(folder)):
                if each.lower() == name.lower() and os.path.isfile(os.path.join(folder, each)):
                    return each
        return None

    def _holds(self, path):
        return path.startswith(self.place.rstrip("/") + "/")

    def read(
        self, name: Union[str, bytes], max_bytes: int = MAX_BYTES
    ) -> Tuple[Optional[bytes], str]:
        """(bytes of the file, "") or (None, why it is not read)."""
        path, reason = self.find(name)
        if path is None:
            return None, reason
        try:
            # its last part cannot have become a link, nor a pipe that would wait for a writer
            descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            with open(descriptor, "rb") as stream:
                status = os.fstat(descriptor)
                if not stat.S_ISREG(status.st_mode):
                    return None, "is no regular file"
                if status.st_size > max_bytes:
                    return None, "has %d bytes, more than %d" % (status.st_size, max_bytes)
                return stream.read(max_bytes), ""
        except OSError as error:
            return None, "cannot be read: %s" % (error.strerror or error)


def _decoded(name: Union[str, bytes]) -> List[str]:
    """The name as text; also as Latin-1 where it is no UTF-8."""
    texts = [os.fsdecode(name)]
    if isinstance(name, bytes):
        try:
            name.decode("utf-8")
        except UnicodeDecodeError:
            texts.append(name.decode("latin-1"))
    return texts


def shown(name: Union[str, bytes]) -> str:
    """A file's name for a note."""
    return one_line(os.fsdecode(name))[:120]
