"""Files beside an export, and whose they are: one that another file names is never overwritten."""
import contextlib
import mmap
import os
import re
from typing import Iterable, Optional

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

# of files that name others; materials after what names them
_NAMING = (".obj", ".ply", ".gltf", ".dae", ".mtl")
_MOST_FILES = 1000  # that are looked into for the owner


def check_side_files(path: PathLike, names: Iterable[str]) -> None:
    """Refuse to overwrite a file that the present file at path does not name.

    names: of files in its folder, in ASCII. Raises MapFileError (exists).
    """
    target = os.path.realpath(os.fsdecode(path))
    folder = os.path.dirname(target)
    for name in names:
        place = os.path.join(folder, name)
        if os.path.lexists(place) and not _is_named(target, name):
            owner = _owner(folder, name, target)
            whose = "%s names it" % one_line(owner) if owner else "no mesh here names it"
            raise MapFileError(
                "exists",
                place,
                "the file exists already, and %s, not %s"
                % (whose, one_line(os.path.basename(target))),
                "name the output otherwise, or move that file away",
            )


def _owner(folder: str, name: str, target: str) -> Optional[str]:
    """The file in the folder that names this one."""
    with contextlib.suppress(OSError):
        found = [each for each in os.listdir(folder) if each.lower().endswith(_NAMING)]
        found.sort(key=lambda each: (each.lower().endswith(_NAMING[-1]), each))
        for each in found[:_MOST_FILES]:
            place = os.path.join(folder, each)
            if each != name and place != target and _is_named(place, name):
                return each
    return None


def _is_named(place: str, name: str) -> bool:
    """Whether a file holds the name, and not as a part of a longer one."""
    pattern = re.compile(rb"(?<![\w.-])%s(?![\w.-])" % re.escape(name.encode("ascii")))
    with contextlib.suppress(OSError, ValueError):  # ValueError: it is empty
        if os.path.isfile(place):
            with open(place, "rb") as stream:
                with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
                    return pattern.search(data) is not None
    return False
