"""Reads the labels that label_manager 1.x kept in a folder: <uuid>/<label>.dat.

Each file has the face indices of a label as decimal numbers with commas between. The released
program wrote a comma before the first one, too: that is no face.
"""
import contextlib
import os
import re
import stat
from dataclasses import dataclass, field
from typing import Dict, Iterator, List, Tuple

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.files.probe import check_name, os_error
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike
from mesh_msgs_hdf5.model.label_names import check_label

_SUFFIX = ".dat"
_MAX_BYTES = 1 << 30
_FACES = re.compile(rb",?(?:[0-9]+(?:,[0-9]+)*)?\s*")
_LARGEST = (1 << 32) - 1
_DIGITS = len(str(_LARGEST))


@dataclass
class DatLabels:
    """The labels of one geometry.

    uuid: the name of its folder. labels: text -> (K,) uint32 face indices, each once, ascending.
    problems: a sentence for each file that is no label.
    """

    uuid: str
    labels: Dict[str, np.ndarray] = field(default_factory=dict)
    problems: List[str] = field(default_factory=list)


def dat_uuids(folder: PathLike) -> List[str]:
    """The UUIDs (or what else the geometries were called) with labels in a folder, sorted.

    Links are not followed. Raises MapFileError (missing, permission, ...).
    """
    with _folder(folder) as descriptor:
        found = []
        for name in _names(descriptor):
            status = os.stat(name, dir_fd=descriptor, follow_symlinks=False)
            if not stat.S_ISDIR(status.st_mode) or not _is_text(name):
                continue
            with contextlib.suppress(MapFileError):
                with _folder(os.path.join(os.fsdecode(folder), name), name, descriptor) as inner:
                    if any(entry.endswith(_SUFFIX) for entry in _names(inner)):
                        found.append(name)
        return found


def read_dat_folder(folder: PathLike, uuid: str) -> DatLabels:
    """All labels of one geometry; nothing outside the folder is read.

    Raises MapFileError (missing: no such UUID; the hint names those that are there).
    """
    folder = os.fsdecode(folder)
    known = dat_uuids(folder)
    if uuid not in known:
        raise MapFileError(
            "missing",
            folder,
            "there are no labels of uuid %r" % uuid[:80],
            "there are labels of: %s" % (", ".join(known) or "none"),
        )
    found = DatLabels(uuid)
    path = os.path.join(folder, uuid)
    with _folder(folder) as top, _folder(path, uuid, top) as inner:
        for name in _names(inner):
            place = os.path.join(path, name)
            if not name.endswith(_SUFFIX):
                found.problems.append("%s: it is no .dat file" % one_line(place))
                continue
            try:
                text = name[: -len(_SUFFIX)]
                check_label(place, text)
                found.labels[text] = parsed(place, _read(place, name, inner))
            except MapFileError as error:
                found.problems.append(str(error))
    return found


def parsed(path: PathLike, data: bytes) -> np.ndarray:
    """The face indices of a .dat file as (K,) uint32, each once, ascending.

    Raises MapFileError (format, index), which says at which byte; path is for it.
    """
    good = _FACES.match(data).end()
    if good != len(data):
        raise MapFileError(
            "format",
            path,
            "%s at byte %d, where a face index or a comma should be"
            % (_shown(data[good : good + 1]), good + 1),
            "the file is damaged, or no label of label_manager 1.x",
        )
    entries = data.strip().lstrip(b",").split(b",")
    if entries == [b""]:
        return np.zeros(0, np.uint32)
    number = next((i for i, entry in enumerate(entries) if len(entry) > _DIGITS), None)
    if number is None:
        faces = np.array(entries).astype(np.uint64)
        if faces.max() <= _LARGEST:
            return np.unique(faces).astype(np.uint32)
        number = int(np.argmax(faces > _LARGEST))
    raise MapFileError(
        "index",
        path,
        "face index %d, counted from 0, is %s, which no mesh has"
        % (number, entries[number][:20].decode("ascii")),
        "the file is damaged",
    )


def _shown(byte):
    return repr(byte.decode("latin-1"))


def _is_text(name):
    try:
        return bool(name.encode("utf-8")) and name.isprintable()
    except UnicodeEncodeError:
        return False


@contextlib.contextmanager
def _folder(path: PathLike, name: str = "", parent: int = -1) -> Iterator[int]:
    """A descriptor of a folder: of a path, or of a name in the folder parent, which is no link."""
    check_name(path)
    flags = os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC
    try:
        if parent < 0:
            descriptor = os.open(path, flags)
        else:
            descriptor = os.open(name, flags | os.O_NOFOLLOW, dir_fd=parent)
    except OSError as error:
        raise os_error(path, error) from error
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def _names(descriptor: int) -> List[str]:
    return sorted(os.listdir(descriptor))


def _read(path: str, name: str, folder: int) -> bytes:
    """The bytes of a regular file in a folder; a link is not followed."""
    flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    try:
        status = os.stat(name, dir_fd=folder, follow_symlinks=False)
        problem = _problem(status)
        if problem:
            raise MapFileError(problem[0], path, problem[1], "")
        with open(os.open(name, flags, dir_fd=folder), "rb") as stream:
            problem = _problem(os.fstat(stream.fileno()))
            if problem:
                raise MapFileError(problem[0], path, problem[1], "")
            return stream.read(_MAX_BYTES)
    except OSError as error:
        raise os_error(path, error) from error


def _problem(status: os.stat_result) -> Tuple[str, ...]:
    if stat.S_ISLNK(status.st_mode):
        return "link", "it is a link, which is not followed"
    if not stat.S_ISREG(status.st_mode):
        return "not_regular", "it is no regular file"
    if status.st_size > _MAX_BYTES:
        return "size", "it has %d bytes, too many for a label" % status.st_size
    return ()
