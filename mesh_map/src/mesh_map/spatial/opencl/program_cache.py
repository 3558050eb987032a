"""Files that keep compiled programs from one start to the next.

Not pyopencl's own cache: it holds pickles, and a process that is killed leaves a lock in it for
which the next ones wait.
"""

import hashlib
import os
import stat
import tempfile
from typing import Optional

_MAGIC = b"MESHCLPY01"
_MAX_SIZE = 1 << 28  # far above any program


def default_folder() -> str:
    """mesh_tools/opencl in $XDG_CACHE_HOME or in ~/.cache; "" where there is neither."""
    cache = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(cache):  # which the XDG base directory specification tells to ignore
        home = os.environ.get("HOME", "")
        if not os.path.isabs(home):
            return ""
        cache = os.path.join(home, ".cache")
    return os.path.join(cache, "mesh_tools", "opencl")


class ProgramCache:
    """One file for each key, a text of all that a program depends on.

    What goes wrong with the files only costs the time to compile again.
    """

    def __init__(self, folder: Optional[str] = None) -> None:
        """Args:
        folder: "" keeps nothing; None for default_folder().
        """
        self._folder = default_folder() if folder is None else folder

    def path(self, key: str) -> str:
        name = hashlib.sha256(key.encode()).hexdigest()[:32] + ".pybin"
        return os.path.join(self._folder, name)

    def load(self, key: str) -> Optional[bytes]:
        """None where there is no file, it is damaged, or somebody else could have written it."""
        if not self._folder:
            return None
        try:
            flags = os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK
            with open(os.open(self.path(key), flags), "rb") as file:
                status = os.fstat(file.fileno())
                if (
                    not stat.S_ISREG(status.st_mode)
                    or status.st_uid != os.geteuid()
                    or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
                    or status.st_size > _MAX_SIZE
                ):
                    return None
                data = file.read()
        except OSError:
            return None
        start = len(_MAGIC) + 32
        binary = data[start:]
        return binary if binary and data[:start] == _MAGIC + _digest(key, binary) else None

    def store(self, key: str, binary: bytes) -> bool:
        """Replaces the file as a whole, or leaves it as it is and returns False."""
        if not self._folder or not binary or len(binary) > _MAX_SIZE // 2:
            return False
        try:
            os.makedirs(self._folder, mode=0o700, exist_ok=True)
            handle, temporary = tempfile.mkstemp(dir=self._folder)  # for the user alone
        except OSError:
            return False
        try:
            with open(handle, "wb") as file:
                file.write(_MAGIC + _digest(key, binary) + binary)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, self.path(key))
        except OSError:
            try:
                os.unlink(temporary)
            except OSError:
                pass
            return False
        return True


def _digest(key: str, binary: bytes) -> bytes:
    return hashlib.sha256(key.encode() + b"\0" + binary).digest()
