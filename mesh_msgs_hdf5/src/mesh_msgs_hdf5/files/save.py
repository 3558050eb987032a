"""Puts bytes in the place of a file so that the old or the new file is there at every moment."""
import contextlib
import errno
import fcntl
import os
import pwd
import secrets
import stat as stat_bits
import time
from typing import Callable, List, Optional, Tuple, Union

from mesh_msgs_hdf5.files.probe import check_name
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

Stamp = Tuple[int, int, int, int, int]
Content = Union[bytes, memoryview, Callable[[int], None]]

_PREFIX, _SUFFIX = ".", ".mesh_msgs_hdf5.tmp"
WRITE_BYTES = 16 << 20
LOCK_SECONDS = 20
_WRITE = stat_bits.S_IWUSR | stat_bits.S_IWGRP | stat_bits.S_IWOTH
_HINTS = {
    errno.ENOSPC: "make room on the disk",
    errno.EDQUOT: "the quota is used up: make room",
    errno.EACCES: "choose a folder you may write to",
    errno.EPERM: "choose a folder you may write to",
    errno.EROFS: "the disk is read-only: choose another folder",
    errno.ENOENT: "make the folder first",
    errno.ENOTDIR: "make the folder first",
    errno.EXDEV: "it is mounted by itself: mount its folder, or name another one",
    errno.EBUSY: "it is mounted by itself: mount its folder, or name another one",
    errno.EFBIG: "the file would be larger than this disk or user may have: save elsewhere",
    errno.EIO: "the disk reports an error: save elsewhere",
}


def stamp(path: PathLike) -> Optional[Stamp]:
    """What changes whenever another file takes this place, or this one is written to; None if there
    is no file. Only to be compared for equality: clocks jump.
    """
    try:
        status = os.stat(path)
    except OSError:
        return None
    times = status.st_mtime_ns, status.st_ctime_ns
    return (status.st_dev, status.st_ino, status.st_size) + times


def check_target(path: PathLike, overwrite: bool) -> None:
    """Refuse early, before long work, a place where save_file would fail for a plain reason."""
    check_name(path)
    target = os.path.realpath(os.fsdecode(path))
    folder = os.path.dirname(target)
    if os.path.isdir(target) or os.fsdecode(path).endswith("/"):
        raise MapFileError("directory", path, "it is a folder, not a file", "name a file inside it")
    if not os.path.isdir(folder):
        raise MapFileError("save", path, "the folder %s does not exist" % folder, "make it first")
    if os.path.exists(target):
        if not overwrite:
            raise MapFileError(
                "exists", path, "the file exists already", "use --force to replace it"
            )
        if not os.path.isfile(target):
            raise MapFileError("not_regular", path, "it is no regular file", "name another one")
        mode = os.stat(target).st_mode
        # root may write to any file, but whoever has made it read-only means that
        if not mode & _WRITE or not os.access(target, os.W_OK):
            _check_disk(path, folder)
            raise MapFileError("save", path, "the file is read-only", _write_hint(target))
    if not os.access(folder, os.W_OK | os.X_OK):
        _check_disk(path, folder)
        raise MapFileError(
            "save", path, "no permission to write to the folder %s" % folder, _HINTS[errno.EACCES]
        )


def _write_hint(target):
    status = os.stat(target)
    if os.geteuid() in (0, status.st_uid):
        return "chmod u+w, or name another one"
    try:
        owner = pwd.getpwuid(status.st_uid).pw_name
    except KeyError:
        owner = "the user %d" % status.st_uid
    return "it belongs to %s: save as that user, or name another one" % owner


def _check_disk(path, folder):
    """Refuse a disk on which nobody may write, whatever the permissions."""
    with contextlib.suppress(OSError):  # then permissions are the reason
        if os.statvfs(folder).f_flag & os.ST_RDONLY:
            hint = "choose a folder on another one"
            raise MapFileError("save", path, "the disk is read-only", hint)


def save_file(
    path: PathLike,
    content: Content,
    expected: Optional[Stamp] = None,
    overwrite: bool = True,
) -> None:
    """Replace the file (or the one that a link leads to) by new content, or leave it as it was.

    A temporary file in the same folder gets the old file's mode, owner and extended attributes and
    the content (bytes, or a function that fills the file of an open descriptor), is synced to the
    disk and takes the old one's place in one step; then the folder is synced. expected: what
    stamp() was when the old file was read; another one now means that somebody else saved, and is
    refused. Raises MapFileError (save, changed, exists, and what content raises).
    """
    check_target(path, overwrite)
    target = os.path.realpath(os.fsdecode(path))
    try:
        _check_unchanged(path, target, expected)
        descriptor, temporary = _create_temporary(target)
        try:
            with contextlib.ExitStack() as opened:
                closing = opened.enter_context(_closing(descriptor))
                _fill(descriptor, target, content)
                folder = opened.enter_context(_locked_folder(os.path.dirname(target)))
                check_target(path, overwrite)
                _check_unchanged(path, target, expected)
                # closed under the lock of the folder, or others would sweep it; and before it is
                # in place, because a disk over the network reports errors here
                closing.close()
                os.replace(temporary, target)
                try:
                    sync_folder(folder)
                except OSError as error:
                    raise _NotSynced(error.errno, error.strerror) from error
        except _NotSynced:
            raise
        except BaseException:  # also an interrupt: leave nothing behind
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
    except OSError as error:
        reason = error.strerror or str(error)
        if isinstance(error, _NotSynced):
            message = "is saved, but may be lost if the power fails now: %s" % reason
        else:
            message = "cannot be saved, nothing was changed: %s" % reason
        raise MapFileError("save", path, message, _HINTS.get(error.errno, "")) from error


def _check_unchanged(path, target, expected):
    if expected is not None and stamp(target) != expected:
        raise MapFileError("changed", path, "another program saved it meanwhile", "open it again")


class _NotSynced(OSError):
    """The new file is in place, but its folder could not be synced."""


class _closing:
    """A descriptor that is closed once: by close(), which raises, or at the end of the context."""

    def __init__(self, descriptor):
        self._descriptor = descriptor

    def __enter__(self):
        return self

    def close(self):
        descriptor, self._descriptor = self._descriptor, None
        os.close(descriptor)

    def __exit__(self, *_error):
        if self._descriptor is not None:
            with contextlib.suppress(OSError):  # the save has failed already
                self.close()


def write_all(descriptor: int, data: Union[bytes, memoryview]) -> None:
    """Write all of it, however little the system takes at once. Raises OSError."""
    view = memoryview(data).cast("B")
    while view:
        view = view[os.write(descriptor, view[:WRITE_BYTES]) :]


def _fill(descriptor, target, content):
    with contextlib.suppress(FileNotFoundError):
        old = os.stat(target)
        with contextlib.suppress(PermissionError):  # root keeps the owner, others own it
            os.fchown(descriptor, old.st_uid, old.st_gid)
        os.fchmod(descriptor, old.st_mode & 0o7777)
        _copy_extended_attributes(target, descriptor)
    if callable(content):
        content(descriptor)
    else:
        write_all(descriptor, content)
    os.fsync(descriptor)


def _copy_extended_attributes(target, descriptor):
    """Notes of the user and access control lists, as far as this disk and user may have them."""
    with contextlib.suppress(OSError):
        for name in os.listxattr(target):
            with contextlib.suppress(OSError):
                os.setxattr(descriptor, name, os.getxattr(target, name))


def sync_folder(descriptor: int) -> None:
    """Make the names in an open folder safe on the disk. Raises OSError."""
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # a file system that does not sync folders
            raise


def temporary_path(target: str, token: str) -> str:
    """The name beside a file that has its new content until that takes its place.

    The name's end is cut so that the temporary name is never longer than a name may be.
    """
    folder, name = os.path.split(target)
    short = os.fsdecode(os.fsencode(name)[:200])
    return os.path.join(folder, _PREFIX + short + "." + token + _SUFFIX)


def is_temporary(name: str) -> bool:
    """Whether a file in a folder is named as one that is being saved."""
    return name.startswith(_PREFIX) and name.endswith(_SUFFIX)


def temporary_paths(target: str) -> List[str]:
    """The temporary files beside a file that are there, in use or not; sorted."""
    folder = os.path.dirname(target)
    start = temporary_path(target, "")[: -len(_SUFFIX)]
    with contextlib.suppress(OSError):
        paths = (os.path.join(folder, entry) for entry in sorted(os.listdir(folder)))
        return [path for path in paths if path.startswith(start) and path.endswith(_SUFFIX)]
    return []


def _create_temporary(target):
    """An open, locked, new file beside the target; its lock tells others that it is in use.

    What killed programs left there is removed first, which makes room.
    """
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
    with _locked_folder(os.path.dirname(target)):
        _sweep(target)
        while True:
            temporary = temporary_path(target, secrets.token_hex(8))
            try:
                descriptor = os.open(temporary, flags, 0o666)
            except FileExistsError:
                continue
            with contextlib.suppress(OSError):  # no locks on this disk
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return descriptor, temporary


@contextlib.contextmanager
def _locked_folder(folder):
    """The folder's descriptor; programs of this package save into a folder one after the other."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        _wait_for_lock(descriptor)
        yield descriptor
    finally:
        with contextlib.suppress(OSError):  # nothing was written through it
            os.close(descriptor)


def _wait_for_lock(descriptor):
    deadline = time.monotonic() + LOCK_SECONDS
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            if time.monotonic() > deadline:
                raise BlockingIOError(
                    error.errno, "another program has been saving there for %d s" % LOCK_SECONDS
                ) from error
            time.sleep(0.02)
        except OSError:  # a disk without locks
            return
        else:
            return


def _sweep(target):
    """Remove what killed programs left of saving this file; what is locked is still in use."""
    for stale in temporary_paths(target):
        with contextlib.suppress(OSError):
            _remove_if_unlocked(stale)


def _remove_if_unlocked(path):
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.unlink(path)
    finally:
        os.close(descriptor)
