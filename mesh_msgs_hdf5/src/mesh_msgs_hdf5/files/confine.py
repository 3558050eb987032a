"""File names that come from a ROS message or service stay inside one folder."""
import os
import stat
from typing import Optional, Sequence

from mesh_msgs_hdf5.files.probe import os_error
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

MAX_PART_BYTES = 255  # of one name between two slashes, as Linux has it
MAX_BYTES = 1024
_SHOWN = 80


def confined_path(
    folder: PathLike,
    name: str,
    suffixes: Sequence[str] = (".h5",),
    must_exist: Optional[bool] = None,
) -> str:
    """The real path of a file that a stranger has named, which lies in the folder or below it.

    Anybody who reaches the ROS master may call a service with any text; so the name is looked at
    before the file system is, and links are followed before it is decided where the file lies.
    name: relative to the folder (an absolute one must lead into it). suffixes: in small letters,
    one of which it must have. must_exist: True for a file to be read, False for one that must not
    be there yet, None for either. The folder that is to hold the file must be there.

    The path has no links in it; it tells nothing about what happens to the folder afterwards. Give
    it to open(), never to a shell. Raises MapFileError: name; missing, exists as must_exist says.
    """
    base = os.path.realpath(os.fsdecode(folder))
    _check_text(folder, name, suffixes)
    path = os.path.realpath(os.path.join(base, name))
    if not _is_below(path, base):
        raise _refused(folder, name, "leads out of the folder")
    if os.path.splitext(path)[1].lower() not in suffixes:
        raise _refused(folder, name, "leads to a file that does not end with %s", suffixes)
    try:
        mode = os.lstat(path).st_mode
    except FileNotFoundError as error:
        if must_exist or not os.path.isdir(os.path.dirname(path)):
            raise os_error(path, error) from error
        return path
    except OSError as error:
        raise os_error(path, error) from error
    if not stat.S_ISREG(mode):
        raise _refused(folder, name, "is no regular file")
    if must_exist is False:
        raise MapFileError("exists", path, "the file exists already", "choose another name")
    return path


def _check_text(folder, name, suffixes):
    """Refuse what is wrong by the text alone."""
    try:
        raw = name.encode("utf-8")
    except UnicodeEncodeError as error:
        raise _refused(folder, name, "is no UTF-8 text") from error
    parts = name.split("/")
    if len(raw) > MAX_BYTES or max(len(part.encode()) for part in parts) > MAX_PART_BYTES:
        raise _refused(folder, name, "is too long")
    if not name.isprintable():
        raise _refused(folder, name, "contains a control character")
    if ".." in parts:
        raise _refused(folder, name, "contains ..")
    if parts[-1] in ("", "."):
        raise _refused(folder, name, "names no file")
    if os.path.splitext(parts[-1])[1].lower() not in suffixes:
        raise _refused(folder, name, "does not end with %s", suffixes)


def _is_below(path, base):
    return path.startswith(base.rstrip("/") + "/")


def _refused(folder, name, reason, suffixes=()):
    reason = reason % " or ".join(suffixes) if suffixes else reason
    shown = "%r%s" % (name[:_SHOWN], "..." if len(name) > _SHOWN else "")
    return MapFileError(
        "name",
        folder,
        "the file name %s %s" % (shown, reason),
        "name a file in this folder, for example garden%s" % (suffixes or (".h5",))[0],
    )
