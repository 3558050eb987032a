"""Sets references to objects anew in a copy of a file, in which the objects are elsewhere.

Copying leaves them empty or, in compounds and lists (netCDF has them for dimensions), wrong.
"""
from typing import Any, Dict, Iterator, List, Optional, Set, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import reached, text_of
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike


def objects_with_references(file: h5py.File, below: str = "") -> List[str]:
    """One path of each object, at or below a path, that holds references, in its values or its
    attributes."""
    found: List[str] = []
    seen: Set[int] = set()
    for place, item in _names(file, below):
        address = h5py.h5o.get_info(item).addr
        if address not in seen:
            seen.add(address)
            if _has_references(item):
                found.append(place or "/")
    return found


def _names(file, below) -> Iterator[Tuple[str, Any]]:
    """(path, object) of each name at or below a path, links apart; groups that have several names
    are gone through once."""
    start = file[below or "/"].id
    yield below, start
    gone = {h5py.h5o.get_info(start).addr}
    groups = [(below, start)]
    while groups:
        place, group = groups.pop()
        for key in group:
            if group.links.get_info(key).type != h5py.h5l.TYPE_HARD:
                continue
            item = h5py.h5o.open(group, key)
            inner = "%s/%s" % (place, text_of(key))
            yield inner, item
            address = h5py.h5o.get_info(item).addr
            if isinstance(item, h5py.h5g.GroupID) and address not in gone:
                gone.add(address)
                groups.append((inner, item))


def _has_references(item):
    if isinstance(item, h5py.h5d.DatasetID) and _refers(item):
        return True
    count = h5py.h5a.get_num_attrs(item)
    return any(_refers(h5py.h5a.open(item, index=index)) for index in range(count))


def _refers(item):
    return item.get_type().detect_class(h5py.h5t.REFERENCE)


def carry_references(
    source: h5py.File,
    target: h5py.File,
    moved: Dict[str, str],
    path: PathLike = "",
    below: str = "",
    closed: bool = False,
) -> None:
    """Make each reference in target lead to the object of the name that it leads to in source.

    moved: old path -> new path of objects that have another name in target. What is not in target
    is left out. path: of the map, for errors. below: a path, only references in what is there
    count, and what is there is meant rather than the same under another name; closed: none may lead
    out of it. Raises MapFileError (link) for a reference to what is not in target.
    """
    mapping = _Mapping(source, target, moved, path, below, closed)
    for place in objects_with_references(source, below):
        one, other = source[place], reached(target, place, moved)
        if other is None:
            continue
        _carry_attributes(mapping, one, other)
        if isinstance(one, h5py.Dataset) and one.shape is not None and _refers(one.id):
            other[()] = mapping.of(one[()])


def _carry_attributes(mapping, one, other):
    for index in range(h5py.h5a.get_num_attrs(one.id)):
        attribute = h5py.h5a.open(one.id, index=index)
        if _refers(attribute) and h5py.h5a.exists(other.id, attribute.name):
            values = np.zeros(attribute.shape, dtype=attribute.dtype)
            values[()] = mapping.of(one.attrs[text_of(attribute.name)])
            h5py.h5a.open(other.id, attribute.name).write(values)


class _Mapping:
    """From references in one file to those in another."""

    def __init__(self, source, target, moved, path, below, closed):
        self._source, self._target, self._moved = source, target, moved
        self._path, self._below, self._closed = path, below, closed
        self._others: Optional[Dict[int, List[str]]] = None
        self._inside: Dict[int, str] = {}
        if below:
            for place, item in _names(source, below):
                self._inside.setdefault(h5py.h5o.get_info(item).addr, place)

    def of(self, value: Any) -> Any:
        """The value with all references in it replaced."""
        if isinstance(value, h5py.Reference):
            return self._reference(value)
        if isinstance(value, (np.ndarray, np.void)) and value.dtype.names:
            value = value.copy()
            for name in value.dtype.names:
                value[name] = self.of(value[name])
            return value
        if isinstance(value, np.ndarray) and value.dtype.kind == "O":
            new = value.copy()
            for place in np.ndindex(value.shape):
                new[place] = self.of(value[place])
            return new
        return value

    def _reference(self, reference):
        name = h5py.h5r.get_name(reference, self._source.id) if reference else None
        if name is None:
            return reference  # to nothing
        place = self._new_place(text_of(name), reference).encode("utf-8", "surrogateescape")
        if isinstance(reference, h5py.RegionReference):
            region = h5py.h5r.get_region(reference, self._source.id)
            return h5py.h5r.create(self._target.id, place, h5py.h5r.DATASET_REGION, region)
        return h5py.h5r.create(self._target.id, place, h5py.h5r.OBJECT)

    def _new_place(self, name, reference):
        """Where the object of that name is in the target. Raises MapFileError."""
        address = h5py.h5o.get_info(h5py.h5r.dereference(reference, self._source.id)).addr
        if address in self._inside:
            return self._moved_place(self._inside[address])
        if not self._closed:
            place = self._moved_place(name)
            if reached(self._target, place) is not None:
                return place
            for other in self._other_names(address):
                place = self._moved_place(other)
                if reached(self._target, place) is not None:
                    return place
        raise MapFileError(
            "link",
            self._path,
            "a reference leads to %s, which is not there any more" % name[:200],
            "remove that reference first, with h5py",
        )

    def _moved_place(self, name):
        """The new path of an object which itself, or a group that it is in, may have moved."""
        moved = [old for old in self._moved if (name + "/").startswith(old + "/")]
        old = max(moved, key=len, default="")
        return self._moved[old] + name[len(old) :] if moved else name

    def _other_names(self, address):
        if self._others is None:
            self._others = {}
            for place, item in _names(self._source, ""):
                self._others.setdefault(h5py.h5o.get_info(item).addr, []).append(place or "/")
        return self._others.get(address, [])
