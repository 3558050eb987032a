"""Guarded access to the groups and names of an open HDF5 file.

Nothing outside the file is read. Every function takes the name of the file for its errors. HDF5
follows external links to any file that the process may read; so each step on the way to an object
is looked at before it is taken.
"""
import contextlib
import errno
import functools
import os
import types
from typing import Any, Callable, Iterator, List, Mapping, Optional, Tuple

import h5py

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_NO_LOCK = "unable to lock file"
MAX_CHILDREN = 50_000
_LINK_INFO = 2  # a message in a group's header (HDF5 File Format Specification, IV.A.2.c)
_LINKS = {h5py.h5l.TYPE_SOFT: "a soft link", h5py.h5l.TYPE_EXTERNAL: "an external link"}
# what h5py raises on a damaged file
HDF5_ERRORS = (
    OSError,
    LookupError,
    RuntimeError,
    ValueError,
    TypeError,
    MemoryError,
    AttributeError,
    ArithmeticError,
)
# shape and type are asked for once only; h5py before 3.0 has no such choice
_CACHING = {"readonly": True} if h5py.version.version_tuple[0] >= 3 else {}


@functools.lru_cache(maxsize=None)
def default_budget() -> int:
    """Bytes that the arrays read in one call may have: half of the memory, at most 8 GiB."""
    return min(8 << 30, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2)


@contextlib.contextmanager
def translated_errors(path: PathLike, building: bool = False) -> Iterator[None]:
    """Whatever h5py raises on a damaged file, or in building a new one, becomes a MapFileError."""
    try:
        yield
    except HDF5_ERRORS as error:
        raise translated(path, error, building) from error


def translated(path: PathLike, error: BaseException, building: bool = False) -> MapFileError:
    """The MapFileError of one of HDF5_ERRORS."""
    text = one_line(str(error))[:200] or type(error).__name__
    if building:
        return MapFileError("save", path, "the new file cannot be built: %s" % text, "")
    if isinstance(error, MemoryError):
        return MapFileError(
            "size",
            path,
            "there is not enough memory to read it: %s" % text,
            "is it a mesh map? If so, read its arrays one by one",
        )
    locked = is_locked(error)
    if locked:
        return MapFileError("locked", path, "another program has it open to write", locked)
    if _NO_LOCK in text:
        hint = "the disk has no locks: export HDF5_USE_FILE_LOCKING=FALSE, or copy the file"
        return MapFileError("unreadable", path, "HDF5 says: %s" % text, hint)
    if "truncated file" in text:
        return MapFileError(
            "truncated", path, "the file is cut off (%s)" % text, "copy or fetch it again"
        )
    return MapFileError(
        "damaged",
        path,
        "the file is damaged; HDF5 says: %s" % text,
        "restore it from a copy, or import the mesh again",
    )


def is_locked(error: BaseException) -> str:
    """The way out if HDF5 does not open a file because a program has it open to write; else ""."""
    busy = getattr(error, "errno", None) in (errno.EAGAIN, errno.EACCES)
    if busy and _NO_LOCK in str(error):
        return "close the program that has it open"
    if "already open for write" in str(error):  # a mark in the file, which a killed program leaves
        return "close the program that has it open; if it was killed: h5clear -s FILE"
    return ""


def link_kind(group: h5py.Group, name: str) -> Optional[int]:
    """h5py.h5l.TYPE_HARD, TYPE_SOFT, TYPE_EXTERNAL, ..., or None if there is no such name."""
    key = name.encode("utf-8")
    return group.id.links.get_info(key).type if group.id.links.exists(key) else None


def exists(group: h5py.Group, place: str) -> bool:
    """True if something has that place, were it a link; none is followed on the way."""
    *way, last = place.encode("utf-8").split(b"/")
    found = group.id
    for name in way:
        if not found.links.exists(name) or found.links.get_info(name).type != h5py.h5l.TYPE_HARD:
            return False
        found = h5py.h5o.open(found, name)
        if not isinstance(found, h5py.h5g.GroupID):
            return False
    return found.links.exists(last)


def child(path: PathLike, group: h5py.Group, name: str, kind: Any = h5py.Group) -> Any:
    """The h5py.Group (kind: or h5py.Dataset) of that name in a group, None if there is none.

    Refuses links, and what is of another kind; whether a dataset is safe to read is not asked.
    """
    key, links = name.encode("utf-8"), group.id.links
    if not links.exists(key):
        return None
    link = links.get_info(key).type
    if link != h5py.h5l.TYPE_HARD:
        raise MapFileError(
            "link",
            path,
            "%s is %s" % (join(group, name), _LINKS.get(link, "a link of an unknown kind")),
            "only what is stored in the file itself is read: copy the data into it",
        )
    found = h5py.h5o.open(group.id, key)
    if kind is h5py.Group and isinstance(found, h5py.h5g.GroupID):
        return h5py.Group(found)  # group[name] takes three times as long
    if kind is h5py.Dataset and isinstance(found, h5py.h5d.DatasetID):
        return h5py.Dataset(found, **_CACHING)
    wanted = kind.__name__.lower()
    raise MapFileError("shape", path, "%s is not a %s" % (join(group, name), wanted), "")


def first_keys(group: h5py.Group, most: int) -> List[bytes]:
    """The first names in a group, in no order; no more are looked at than that."""
    keys: List[bytes] = []

    def take(key):
        keys.append(key)
        return True if len(keys) >= most else None  # True ends it

    if most > 0:
        group.id.links.iterate(take, order=h5py.h5.ITER_NATIVE)
    return keys


def children(
    path: PathLike,
    group: h5py.Group,
    most: int = MAX_CHILDREN,
    tell: Optional[Callable[[str], None]] = None,
) -> List[str]:
    """The names in a group, sorted; refuses more than `most`, and names that are not UTF-8.

    tell: is told of those instead, in a sentence for each; they are left out.
    """
    # a group in the new style knows their number; one in the old would count for seconds
    new_style = h5py.h5o.get_info(group.id).hdr.mesg.present >> _LINK_INFO & 1
    too_many = bool(new_style) and len(group) > most
    keys = [] if too_many else first_keys(group, most + 1)
    if too_many or len(keys) > most:
        raise MapFileError(
            "size",
            path,
            "%s has more than the %d entries allowed" % (group.name, most),
            "is it a mesh map?",
        )
    names = []
    for key in keys:
        try:
            names.append(key.decode("utf-8"))
        except UnicodeDecodeError as error:
            text = "a name in %s is not UTF-8: %r" % (group.name, key)
            if tell is None:
                raise MapFileError("value", path, text, "rename it") from error
            tell("left out: " + text)
    return sorted(names)


def is_group_of_this_file(group: h5py.Group, name: str) -> bool:
    """True if the group has a child of that name that is a group and no link."""
    return isinstance(hard_object(group, name), h5py.h5g.GroupID)


def is_dataset_of_this_file(group: h5py.Group, name: str) -> bool:
    """True if the group has a child of that name that is a dataset and no link."""
    return isinstance(hard_object(group, name), h5py.h5d.DatasetID)


def hard_object(group: h5py.Group, name: str) -> Any:
    """The h5py.h5g.GroupID, h5d.DatasetID or h5t.TypeID of a name; None if there is none."""
    if link_kind(group, name) != h5py.h5l.TYPE_HARD:
        return None
    return h5py.h5o.open(group.id, name.encode("utf-8"))


def text_of(key: bytes) -> str:
    """A name of HDF5 as text; bytes that are no UTF-8 as surrogates."""
    return key.decode("utf-8", "surrogateescape")


def opened(group: h5py.Group, key: bytes) -> Any:
    """The h5py object of that name in a group."""
    found = h5py.h5o.open(group.id, key)
    for kind, low in ((h5py.Group, h5py.h5g.GroupID), (h5py.Dataset, h5py.h5d.DatasetID)):
        if isinstance(found, low):
            return kind(found)  # group[name] takes three times as long
    return h5py.Datatype(found)


def reached(file: h5py.File, place: str, moved: Mapping[str, str] = types.MappingProxyType({})):
    """The object at an absolute path, without following links; None if there is none.

    moved: path -> where the object is that is meant by it.
    """
    item, way = file["/"], ""
    for name in filter(None, place.split("/")):
        way += "/" + name
        if way in moved:
            item = file[moved[way]]
            continue
        key = name.encode("utf-8", "surrogateescape")
        if not isinstance(item, h5py.Group) or not item.id.links.exists(key):
            return None
        if item.id.links.get_info(key).type != h5py.h5l.TYPE_HARD:
            return None
        item = opened(item, key)
    return item


def address(group: h5py.Group) -> Tuple[int, int]:
    """What tells an object from all others, whatever its names."""
    info = h5py.h5o.get_info(group.id)
    return info.fileno, info.addr


def join(group: h5py.Group, name: str) -> str:
    """The path of a child, for messages."""
    return "%s/%s" % (group.name.rstrip("/"), name)
