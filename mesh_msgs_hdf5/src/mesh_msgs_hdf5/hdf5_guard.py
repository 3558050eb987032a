"""Guarded access to the objects of an open HDF5 file.

Nothing outside the file is read, no declared size is believed.

Every function takes the name of the file for its errors. HDF5 follows external links, external
storage and virtual datasets to any file that the process may read; so each step on the way to an
object is looked at before it is taken.
"""
import contextlib
import os
from typing import Any, Iterator, List, Optional, Union

import h5py

from mesh_msgs_hdf5.errors import MapFileError, PathLike, one_line

MAX_CHILDREN = 100_000
MAX_ATTRIBUTE_BYTES = 1 << 20
_FILTERS = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32, 32000)
_LINKS = {h5py.h5l.TYPE_SOFT: "a soft link", h5py.h5l.TYPE_EXTERNAL: "an external link"}
_FOREIGN = "only what is stored in the file itself is read: copy the data into it"


def default_budget() -> int:
    """Bytes that one array may have: half of the memory, at most 8 GiB."""
    return min(8 << 30, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2)


@contextlib.contextmanager
def translated_errors(path: PathLike, building: bool = False) -> Iterator[None]:
    """Whatever h5py raises on a damaged file, or in building a new one, becomes a MapFileError."""
    try:
        yield
    except MapFileError:
        raise
    except (
        OSError,
        KeyError,
        RuntimeError,
        ValueError,
        TypeError,
        MemoryError,
        AttributeError,
        OverflowError,
    ) as error:
        text = one_line(str(error))[:200] or type(error).__name__
        if building:
            raise MapFileError(
                "save", path, "the new file cannot be built: %s" % text, ""
            ) from error
        if "truncated file" in text:
            raise MapFileError(
                "truncated", path, "the file is cut off (%s)" % text, "copy or fetch it again"
            ) from error
        raise MapFileError(
            "damaged",
            path,
            "the file is damaged; HDF5 says: %s" % text,
            "restore it from a copy, or import the mesh again",
        ) from error


def child(path: PathLike, group: h5py.Group, name: str) -> Any:
    """The group or dataset of that name in the group, None if there is none; refuses links."""
    key = name.encode("utf-8")
    if not group.id.links.exists(key):
        return None
    kind = group.id.links.get_info(key).type
    if kind != h5py.h5l.TYPE_HARD:
        raise MapFileError(
            "link",
            path,
            "%s is %s" % (join(group, name), _LINKS.get(kind, "a link of an unknown kind")),
            _FOREIGN,
        )
    return group[name]


def children(path: PathLike, group: h5py.Group) -> List[str]:
    """The names in a group, sorted; refuses too many, and names that are not UTF-8."""
    if len(group) > MAX_CHILDREN:
        raise MapFileError(
            "size", path, "%s has %d entries" % (group.name, len(group)), "is it a mesh map?"
        )
    names = []
    for key in group.id:
        try:
            names.append(key.decode("utf-8"))
        except UnicodeDecodeError as error:
            raise MapFileError(
                "value", path, "a name in %s is not UTF-8: %r" % (group.name, key), "rename it"
            ) from error
    return sorted(names)


def is_group_of_this_file(group: h5py.Group, name: str) -> bool:
    """True if the group has a child of that name that is a group and no link."""
    key = name.encode("utf-8")
    if not group.id.links.exists(key) or group.id.links.get_info(key).type != h5py.h5l.TYPE_HARD:
        return False
    return group.get(name, getclass=True) is h5py.Group


def join(group: h5py.Group, name: str) -> str:
    """The path of a child, for messages."""
    return "%s/%s" % (group.name.rstrip("/"), name)


def subgroup(path: PathLike, group: h5py.Group, name: str) -> Optional[h5py.Group]:
    """The group of that name, None if there is none; MapFileError if it is something else."""
    found = child(path, group, name)
    if found is not None and not isinstance(found, h5py.Group):
        raise MapFileError("shape", path, "%s is not a group" % join(group, name), "")
    return found


def dataset(path: PathLike, group: h5py.Group, name: str, budget: int) -> Optional[h5py.Dataset]:
    """The dataset of that name, None if there is none; refused if it cannot be read safely."""
    found = child(path, group, name)
    if found is None:
        return None
    if not isinstance(found, h5py.Dataset):
        raise MapFileError("shape", path, "%s is not a dataset" % join(group, name), "")
    _check_storage(path, found, budget)
    return found


def _check_storage(path, found, budget):
    properties = found.id.get_create_plist()
    if properties.get_external_count():
        raise MapFileError("external", path, "%s is stored in another file" % found.name, _FOREIGN)
    if properties.get_layout() == h5py.h5d.VIRTUAL:
        raise MapFileError("virtual", path, "%s is a virtual dataset" % found.name, _FOREIGN)
    for i in range(properties.get_nfilters()):
        code = properties.get_filter(i)[0]
        if code not in _FILTERS:
            raise MapFileError(
                "filter",
                path,
                "%s is compressed by filter %d, which is not read" % (found.name, code),
                "h5repack -f GZIP=1 FILE NEW_FILE, where that filter is installed",
            )
    if found.shape is None or found.dtype.kind not in "fiu":
        raise MapFileError(
            "dtype", path, "%s holds %s, not numbers" % (found.name, found.dtype), ""
        )
    declared = found.size * found.dtype.itemsize
    if declared > budget:
        raise MapFileError(
            "size",
            path,
            "%s declares %d bytes, more than the %d allowed" % (found.name, declared, budget),
            "is it a mesh map?",
        )
    _check_complete(path, found, properties, declared)


def _check_complete(path, found, properties, declared):
    """HDF5 gives zeros for what was never stored; a mesh must be stored wholly."""
    if properties.get_layout() == h5py.h5d.CHUNKED:
        expected = 1
        for length, chunk in zip(found.shape, found.chunks):
            expected *= -(-length // chunk)
        stored = (
            found.id.get_num_chunks()
            if hasattr(found.id, "get_num_chunks")
            else (expected if found.id.get_storage_size() or not expected else 0)
        )
        complete = stored == expected
    else:
        complete = found.id.get_storage_size() >= declared
    if not complete:
        raise MapFileError(
            "size",
            path,
            "%s declares %d bytes, but not all of them are stored" % (found.name, declared),
            "the file was not written to the end: restore it from a copy",
        )


def attribute(path: PathLike, owner: Any, name: str) -> Union[str, int, float, None]:
    """The value of an attribute: str, int or float; None if there is none."""
    key = name.encode("utf-8")
    if not h5py.h5a.exists(owner.id, key):
        return None
    if h5py.h5a.open(owner.id, key).get_storage_size() > MAX_ATTRIBUTE_BYTES:
        raise MapFileError("size", path, "attribute %s of %s is too big" % (name, owner.name), "")
    value = owner.attrs[name]
    if isinstance(value, bytes):
        try:
            value = value.decode("utf-8")
        except UnicodeDecodeError as error:
            raise MapFileError(
                "value", path, "attribute %s of %s is not UTF-8" % (name, owner.name), ""
            ) from error
    elif hasattr(value, "item") and getattr(value, "size", 0) == 1:
        value = value.item()
    if not isinstance(value, (str, int, float)):
        raise MapFileError(
            "value", path, "attribute %s of %s is no single value" % (name, owner.name), ""
        )
    return value
