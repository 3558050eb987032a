"""Files that a mesh file names: only those in its folder and below are ever opened."""
import os
import stat
from typing import Optional, Tuple, Union

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

        Backslashes separate folders, too. A path that leads elsewhere is looked for by its last
        part: other people's absolute paths are rarely ours.
        """
        text = os.fsdecode(name).strip().strip('"').replace("\\", "/")
        if not text or "\0" in text:
            return None, "has no name"
        for candidate in (text, text.rsplit("/", 1)[-1]):
            found = os.path.realpath(os.path.join(self.place, candidate))
            if self._holds(found) and os.path.isfile(found):
                return found, ""
        if self._holds(os.path.realpath(os.path.join(self.place, text))):
            return None, "is not there"
        return None, "is outside the folder of the mesh, where nothing is read"

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


def shown(name: Union[str, bytes]) -> str:
    """A file's name for a note."""
    return one_line(os.fsdecode(name))[:120]
