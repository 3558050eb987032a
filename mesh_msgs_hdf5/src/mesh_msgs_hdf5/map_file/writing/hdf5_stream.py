"""HDF5 files that are being built: in memory, or on disk in a file that is open already.

HDF5 gets a path to the open descriptor. (It can also write through Python objects; but then it
waits for Python inside its own lock, and another thread that uses it meanwhile waits for that.)
"""
import contextlib
import errno
import fcntl
import os
import resource
from typing import Any, Callable, Dict, Iterator, Optional

import h5py

from mesh_msgs_hdf5.files.save import write_all
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import translated_errors
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

# the temporary file has a lock of ours, which HDF5's own would wait for; h5py before 3.5 cannot
# choose, and HDF5's lock takes the place of ours then
_CAN_CHOOSE_LOCKS = h5py.version.version_tuple[:2] >= (3, 5)
_OPEN_FILES = "/proc/self/fd"
_EMPTY_BYTES = 1 << 16
_COPY_BYTES = 4 << 20  # at a time
# this driver takes a path that leads to a file without a name
_DRIVER: Dict[str, Any] = {"driver": "stdio"}
if _CAN_CHOOSE_LOCKS:
    _DRIVER["locking"] = False


class Stream:
    """A file to be built in: an open, empty descriptor.

    room: bytes on disk that are reserved first, because HDF5 1.10 closes a file on a full disk
    "successfully" with zeros in it, and makes the program crash at its end. 0: in memory.
    """

    def __init__(self, descriptor: int, room: int = 0) -> None:
        self.descriptor = descriptor
        self.name = "%s/%d" % (_OPEN_FILES, descriptor)
        self.room = room

    def fill(self, data: bytes) -> None:
        """Make this the content and reserve the room. Raises OSError."""
        write_all(self.descriptor, data)
        os.posix_fallocate(self.descriptor, 0, self.room)


@contextlib.contextmanager
def memory_stream(room: int = 0) -> Iterator[Stream]:
    """A stream in memory, for at most so many bytes.

    Raises OSError where this process must not make files of that size (ulimit -f), on which HDF5
    crashes.
    """
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
    if limit != resource.RLIM_INFINITY and room > limit:
        raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
    descriptor = os.memfd_create("map", os.MFD_CLOEXEC)
    try:
        yield Stream(descriptor)
    finally:
        with contextlib.suppress(OSError):  # it is saved already, or will not be
            os.close(descriptor)


def copied(stream: Stream) -> Callable[[int], None]:
    """A function that writes what was built to a descriptor. It raises OSError."""

    def copy(descriptor: int) -> None:
        place = 0
        while True:
            data = os.pread(stream.descriptor, _COPY_BYTES, place)
            if not data:
                return
            place += len(data)
            write_all(descriptor, data)

    return copy


@contextlib.contextmanager
def building(
    stream: Stream, path: PathLike, like: Optional[h5py.File] = None
) -> Iterator[h5py.File]:
    """An empty h5py.File in a stream; what goes wrong inside is a MapFileError with this path.

    like: a file whose generation of the format, order of names and user block the new one gets.
    Raises OSError where there is no room for it.
    """
    if not os.path.isdir(_OPEN_FILES):
        raise MapFileError(
            "save",
            path,
            "cannot be saved, nothing was changed: %s is not there" % _OPEN_FILES,
            "mount -t proc proc /proc",
        )
    manner = _manner(like)
    mode = "w"
    if stream.room:
        stream.fill(_empty_file(path, manner))
        mode = "r+"  # "w" would give the room back
        manner = {"libver": manner["libver"]}
    with _unlocked(stream), translated_errors(path, building=True):
        with h5py.File(stream.name, mode, **manner, **_DRIVER) as file:
            yield file
        if like is not None and like.userblock_size:
            with open(like.filename, "rb") as block:
                os.pwrite(stream.descriptor, block.read(like.userblock_size), 0)


@contextlib.contextmanager
def reading_stream(stream: Stream, path: PathLike) -> Iterator[h5py.File]:
    """What was built, read only."""
    with _unlocked(stream), translated_errors(path):
        with h5py.File(stream.name, "r", **_DRIVER) as file:
            yield file


def _manner(like: Optional[h5py.File]) -> Dict[str, Any]:
    if like is None:
        return {"libver": "earliest"}
    properties = like.id.get_create_plist()
    manner: Dict[str, Any] = {
        # objects of newer generations do not fit into a file of the first one
        "libver": "latest" if properties.get_version()[0] >= 2 else "earliest",
        "track_order": bool(like["/"].id.get_create_plist().get_link_creation_order()),
    }
    if like.userblock_size:
        manner["userblock_size"] = like.userblock_size
    return manner


def _empty_file(path, manner):
    with memory_stream(_EMPTY_BYTES) as stream:
        with translated_errors(path, building=True):
            with h5py.File(stream.name, "w", **manner, **_DRIVER):
                pass
        return os.pread(stream.descriptor, os.fstat(stream.descriptor).st_size, 0)


@contextlib.contextmanager
def _unlocked(stream):
    if not stream.room or _CAN_CHOOSE_LOCKS:
        yield
        return
    with contextlib.suppress(OSError):
        fcntl.flock(stream.descriptor, fcntl.LOCK_UN)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            fcntl.flock(stream.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
