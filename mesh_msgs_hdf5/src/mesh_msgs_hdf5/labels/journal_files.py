"""What the label journal does to the disk: regular files in one folder, links are not followed."""
import contextlib
import errno
import fcntl
import os
import secrets
import stat
from typing import Iterable, List, Optional

from mesh_msgs_hdf5.files import save
from mesh_msgs_hdf5.files.probe import check_name
from mesh_msgs_hdf5.files.save import write_all
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_DAMAGED = ".damaged"
_FLAGS = os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK
_HINTS = {
    errno.ENOSPC: "make room on the disk",
    errno.EDQUOT: "the quota is used up: make room",
    errno.EACCES: "labels need a folder and files that you may write to",
    errno.EPERM: "labels need a folder and files that you may write to",
    errno.EROFS: "the disk is read-only: copy the map to another folder",
    errno.ENOENT: "make the folder first",
    errno.ENAMETOOLONG: "choose a shorter name for the map",
    errno.EIO: "the disk reports an error: copy the map to another one",
}


def save_error(path: PathLike, message: str, error: OSError) -> MapFileError:
    """The MapFileError of something that could not be done."""
    if error.errno == errno.ELOOP:
        return MapFileError("link", path, "it is a link, which is not followed", "remove it")
    reason = "%s: %s" % (message, error.strerror or error)
    return MapFileError("save", path, reason, _HINTS.get(error.errno, ""))


def open_existing(path: PathLike, mode: int) -> Optional[int]:
    """A descriptor of a regular file; None if there is no file. Raises MapFileError."""
    check_name(path)
    try:
        descriptor = os.open(path, mode | _FLAGS)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise save_error(path, "it cannot be opened", error) from error
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise MapFileError("not_regular", path, "it is no regular file", "move it away")
    return descriptor


def create(path: PathLike, like: Optional[PathLike]) -> Optional[int]:
    """A descriptor of a new, empty file, safe in its folder; None if there is one already.

    It gets the owner and permissions of the file `like`, without execution. Raises MapFileError.
    """
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_EXCL | _FLAGS, 0o644)
    except FileExistsError:
        return None
    except OSError as error:
        raise save_error(path, "no journal can be made for labels", error) from error
    try:
        _adopt(descriptor, like)
        sync_folder(path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            os.unlink(path)
        os.close(descriptor)
        if isinstance(error, OSError):
            raise save_error(path, "no journal can be made for labels", error) from error
        raise
    return descriptor


def _adopt(descriptor, like):
    if like is None:
        return
    try:
        model = os.stat(like)
    except FileNotFoundError:
        return
    with contextlib.suppress(PermissionError):  # root gives it away, others keep it
        os.fchown(descriptor, model.st_uid, model.st_gid)
    os.fchmod(descriptor, model.st_mode & 0o666 | stat.S_IRUSR | stat.S_IWUSR)


def is_at(descriptor: int, path: PathLike) -> bool:
    """True if the open file is the one of that name."""
    try:
        there = os.stat(path, follow_symlinks=False)
    except OSError:
        return False
    here = os.fstat(descriptor)
    return (here.st_dev, here.st_ino) == (there.st_dev, there.st_ino)


def cut(descriptor: int, end: int) -> None:
    """Make the file end there, on the disk too. Raises OSError."""
    os.ftruncate(descriptor, end)
    os.fsync(descriptor)


def sync_folder(path: PathLike) -> None:
    """Make the name of a file safe on the disk. Raises OSError."""
    folder = os.path.dirname(os.path.abspath(os.fsdecode(path)))
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        save.sync_folder(descriptor)
    finally:
        os.close(descriptor)


def replace(path: PathLike, lines: Iterable[bytes], like: Optional[PathLike]) -> int:
    """Put a new file with these lines in the place of path; returns its descriptor, locked.

    The folder is not synced yet. Raises OSError; then the old file is untouched.
    """
    # save.py sweeps those of killed programs
    temporary = save.temporary_path(os.fsdecode(path), secrets.token_hex(8))
    flags = os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_EXCL | _FLAGS
    descriptor = os.open(temporary, flags, 0o644)
    try:
        with contextlib.suppress(OSError):  # no locks on this disk
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        _adopt(descriptor, like)
        for line in lines:
            write_all(descriptor, line)
        os.fsync(descriptor)
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        os.close(descriptor)
        raise
    return descriptor


def keep_damaged(path: PathLike, lines: List[bytes], like: Optional[PathLike]) -> str:
    """Put damaged lines of a journal, each once, into a file beside it; returns its name.

    Raises OSError or MapFileError.
    """
    place = os.fsdecode(path) + _DAMAGED
    if not lines:
        return place
    descriptor = open_existing(place, os.O_RDWR | os.O_APPEND)
    if descriptor is None:
        descriptor = create(place, like)
    if descriptor is None:
        raise FileExistsError(errno.EEXIST, "another program writes %s" % place)
    try:
        with open(descriptor, "rb", closefd=False) as stream:
            known = stream.read().split(b"\n")
        missing = [line for line in lines if line not in set(known)]
        start = b"\n" if known[-1] else b""  # a program was killed while it wrote the last line
        write_all(descriptor, start + b"".join(line + b"\n" for line in missing))
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
    return place
