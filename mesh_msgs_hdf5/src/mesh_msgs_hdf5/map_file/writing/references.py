"""Sets references to objects anew in a copy of a file, in which the objects are elsewhere.

Copying leaves them empty or, in compounds and lists (netCDF has them for dimensions), wrong.
"""
from typing import Any, Dict, List, Set

import h5py
import numpy as np

from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import reached, text_of


def objects_with_references(file: h5py.File) -> List[str]:
    """One path of each object that holds references, in its values or its attributes."""
    found: List[str] = []
    seen: Set[int] = set()
    groups = [("", file["/"].id)]
    if _has_references(file["/"].id):
        found.append("/")
    while groups:
        place, group = groups.pop()
        for key in group:
            if group.links.get_info(key).type != h5py.h5l.TYPE_HARD:
                continue
            item = h5py.h5o.open(group, key)
            address = h5py.h5o.get_info(item).addr
            if address in seen:
                continue
            seen.add(address)
            below = "%s/%s" % (place, text_of(key))
            if _has_references(item):
                found.append(below)
            if isinstance(item, h5py.h5g.GroupID):
                groups.append((below, item))
    return found


def _has_references(item):
    if isinstance(item, h5py.h5d.DatasetID) and _refers(item):
        return True
    count = h5py.h5a.get_num_attrs(item)
    return any(_refers(h5py.h5a.open(item, index=index)) for index in range(count))


def _refers(item):
    return item.get_type().detect_class(h5py.h5t.REFERENCE)


def carry_references(source: h5py.File, target: h5py.File, moved: Dict[str, str]) -> None:
    """Make each reference in target lead to the object of the name that it leads to in source.

    moved: old path -> new path of objects that have another name in target. What is not in target
    is left out.
    """
    mapping = _Mapping(source, target, moved)
    for place in objects_with_references(source):
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

    def __init__(self, source, target, moved):
        self._source, self._target, self._moved = source, target, moved

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
        name = self._moved.get(text_of(name), text_of(name)).encode("utf-8", "surrogateescape")
        if isinstance(reference, h5py.RegionReference):
            region = h5py.h5r.get_region(reference, self._source.id)
            return h5py.h5r.create(self._target.id, name, h5py.h5r.DATASET_REGION, region)
        return h5py.h5r.create(self._target.id, name, h5py.h5r.OBJECT)
