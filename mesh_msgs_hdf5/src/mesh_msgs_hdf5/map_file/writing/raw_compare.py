"""Compares two HDF5 files object by object as they are stored: nothing is decompressed."""
import math
from typing import Any, Collection, Dict, Iterable, Iterator, List, Optional, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.map_file.hdf5 import chunks
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import opened, reached, text_of
from mesh_msgs_hdf5.map_file.writing.object_writer import not_the_same
from mesh_msgs_hdf5.model.errors import PathLike

_SLICE_BYTES = 4 << 20
_STRINGS_AND_THE_LIKE = (h5py.h5t.VLEN, h5py.h5t.STRING, h5py.h5t.REFERENCE)


def is_plain(kind: h5py.h5t.TypeID) -> bool:
    """True if the bytes in the file say everything."""
    if kind.get_class() == h5py.h5t.STRING:
        return not kind.is_variable_str()
    return not any(kind.detect_class(other) for other in _STRINGS_AND_THE_LIKE)


def raw_attribute(attribute: h5py.h5a.AttrID) -> bytes:
    """The bytes of an attribute of a plain type."""
    kind = attribute.get_type()
    values = np.zeros(attribute.shape, dtype="V%d" % kind.get_size())
    attribute.read(values, kind)
    return values.tobytes()


def storage(properties: h5py.h5p.PropDCID) -> Tuple[Any, ...]:
    """How a dataset is stored: layout, chunks, filters, files outside."""
    filters = [properties.get_filter(i) for i in range(properties.get_nfilters())]
    outside = [properties.get_external(i) for i in range(properties.get_external_count())]
    layout = properties.get_layout()
    chunk = properties.get_chunk() if layout == h5py.h5d.CHUNKED else None
    return layout, chunk, filters, outside


def slices(dataset: h5py.Dataset) -> Iterator[Any]:
    """Indices that together are the whole dataset, in pieces of some 4 MB of it."""
    shape = dataset.shape
    if 0 in shape:
        return
    if not shape:
        yield ()
        return
    rows = shape[0]
    row_bytes = math.prod(shape[1:]) * dataset.id.get_type().get_size()
    step = max(1, _SLICE_BYTES // max(1, row_bytes))
    for start in range(0, rows, step):
        yield slice(start, min(start + step, rows))


def raw_rows(dataset: h5py.Dataset, rows: Any) -> bytes:
    """The bytes of some rows, in the type that they have in the file."""
    kind = dataset.id.get_type()
    shape, memory, stored = dataset.shape, h5py.h5s.ALL, h5py.h5s.ALL
    if rows != () and rows != slice(0, shape[0]):
        shape = (rows.stop - rows.start,) + shape[1:]
        memory, stored = h5py.h5s.create_simple(shape), dataset.id.get_space()
        stored.select_hyperslab((rows.start,) + (0,) * (len(shape) - 1), shape)
    values = np.zeros(shape, dtype="V%d" % kind.get_size())
    dataset.id.read(memory, stored, values, kind)
    return values.tobytes()


def same_chunks(one: h5py.Dataset, other: h5py.Dataset) -> bool:
    """True if the same chunks are stored with the same bytes, whatever filters made them."""
    if not hasattr(one.id, "get_num_chunks"):  # HDF5 before 1.10.5 does not tell
        return all(one[rows].tobytes() == other[rows].tobytes() for rows in slices(one))
    if one.id.get_num_chunks() != other.id.get_num_chunks():
        return False
    for offset in _chunk_offsets(one):
        info = other.id.get_chunk_info_by_coord(offset)
        if info.byte_offset is None:
            return False
        if one.id.read_direct_chunk(offset) != other.id.read_direct_chunk(offset):
            return False
    return True


def _chunk_offsets(dataset):
    """Where the stored chunks begin."""
    count = dataset.id.get_num_chunks()
    grid = [-(-length // side) for length, side in zip(dataset.shape, dataset.chunks)]
    if count < int(np.prod(grid, dtype=object)):  # only some are there
        return [dataset.id.get_chunk_info(index).chunk_offset for index in range(count)]
    return (
        tuple(index * side for index, side in zip(place, dataset.chunks))
        for place in np.ndindex(*grid)
    )


class RawComparison:
    """What must be the same in two open files.

    removed: absolute paths in the old file, created: in the new file, that are not compared, nor
    what is below them. moved: old path -> new path. changed: (path, name) of attributes that are
    not compared. recoded: paths of datasets that may be stored in another way.

    Groups may have several names; so a path stands for (address of its group, last name).
    """

    def __init__(
        self,
        path: PathLike,
        removed: Collection[str] = (),
        created: Collection[str] = (),
        moved: Optional[Dict[str, str]] = None,
        changed: Collection[Tuple[str, str]] = (),
        recoded: Collection[str] = (),
    ) -> None:
        self._path = path
        self._removed, self._created, self._changed = removed, created, changed
        self._recoded = recoded
        self._moved = moved or {}
        self._partners: Dict[Any, Any] = {}
        self._references: List[Tuple[Any, Any]] = []

    def check(
        self, old: h5py.File, new: h5py.File, old_start: str = "/", new_start: str = "/"
    ) -> None:
        """Raise MapFileError (save) with the first path at which the files differ.

        old_start, new_start: only these groups, and what is in them, are compared.
        """
        self._new = new
        self._removed_links = _links(old, self._removed)
        self._created_links = _links(new, self._created)
        self._moved_links = _links(old, self._moved)
        self._recoded_objects = {_address(old[place]) for place in self._recoded}
        changed = [
            "%s/%s" % (place.rstrip("/"), name)
            for place, name in self._changed
            if place not in self._created
        ]
        self._changed_of_old, self._changed_of_new = _links(old, changed), _links(new, changed)
        self._is_part = old_start != "/"
        pairs = [(old_start.rstrip("/"), old[old_start], new[new_start])]
        self._is_known(old[old_start], new[new_start])
        while pairs:
            place, one, other = pairs.pop()
            self._check_attributes(place or "/", one, other)
            address = _address(one)
            for name, key in _names(one):
                link = address, name
                if link in self._removed_links and link not in self._moved_links:
                    continue
                below = "%s/%s" % (place, name)
                found = self._partner(below, self._moved_links.get(link), one, other, key)
                if found is None:
                    continue
                item, partner = found
                if isinstance(item, h5py.Group):
                    pairs.append((below, item, partner))
                else:
                    self._check_attributes(below, item, partner)
                    if isinstance(item, h5py.Dataset):
                        self._check_dataset(below, item, partner)
            self._check_names(place, one, other)
        self._check_references(old, new)

    def _check_names(self, place, one, other):
        address, new_address = _address(one), _address(other)
        expected = {
            name
            for name, _ in _names(one)
            if (address, name) not in self._removed_links
            and (address, name) not in self._moved_links
        }
        found = {
            name for name, _ in _names(other) if (new_address, name) not in self._created_links
        }
        if expected != found:
            raise self._differ(place or "/", "names " + ", ".join(sorted(expected ^ found)[:3]))

    def _partner(self, place, moved_from, one, other, key):
        """(object, its partner) behind a link; None for what is no object or was compared."""
        if moved_from is not None:
            way, _, name = self._moved[moved_from].rpartition("/")
            other, new_key = self._new[way or "/"], name.encode("utf-8", "surrogateescape")
        else:
            new_key = key
        if not other.id.links.exists(new_key):
            raise self._differ(place, "missing")
        link = one.id.links.get_info(key)
        if other.id.links.get_info(new_key).type != link.type:
            raise self._differ(place, "kind of link")
        if link.type != h5py.h5l.TYPE_HARD:
            if one.id.links.get_val(key) != other.id.links.get_val(new_key):
                raise self._differ(place, "link")
            return None
        item, partner = (opened(group, k) for group, k in ((one, key), (other, new_key)))
        if type(item) is not type(partner):
            raise self._differ(place, "kind of object")
        known = self._is_known(item, partner)
        if known is False:
            raise self._differ(place, "object")
        return None if known else (item, partner)

    def _is_known(self, item, partner):
        """True if the two were partners before, False if one has another, None if both are new."""
        one, other = (_address(found) for found in (item, partner))
        known = self._partners.setdefault(one, other)
        back = self._partners.setdefault(("back", other), one)
        if known != other or back != one:
            return False
        seen = ("seen", one) in self._partners
        self._partners["seen", one] = True
        return True if seen else None

    def _check_attributes(self, place, one, other):
        if not h5py.h5a.get_num_attrs(one.id) and not h5py.h5a.get_num_attrs(other.id):
            return
        names = _attribute_names(one, self._changed_of_old)
        found = _attribute_names(other, self._changed_of_new)
        if names != found:
            raise self._differ(place, "attributes")
        for name in names:
            a, b = (h5py.h5a.open(owner.id, name) for owner in (one, other))
            same = a.get_type().equal(b.get_type()) and a.shape == b.shape
            same = same and _extent(a) == _extent(b)
            if not same or not self._same_values(one, other, a, b):
                raise self._differ(place, "attribute %s" % text_of(name))

    def _same_values(self, one, other, a, b):
        """Attributes of equal type and shape."""
        if _extent(a) == h5py.h5s.NULL:
            return True
        if is_plain(a.get_type()):
            return raw_attribute(a) == raw_attribute(b)
        return self._same(one.attrs[text_of(a.name)], other.attrs[text_of(b.name)])

    def _check_dataset(self, place, one, other):
        kind = one.id.get_type()
        if not kind.equal(other.id.get_type()):
            raise self._differ(place, "type")
        if one.id.get_space().encode() != other.id.get_space().encode():
            raise self._differ(place, "shape")
        if _address(one) in self._recoded_objects:
            if not identical(chunks.load(one), chunks.load(other)):
                raise self._differ(place, "values")
            return
        a, b = (dataset.id.get_create_plist() for dataset in (one, other))
        if storage(a) != storage(b):
            raise self._differ(place, "storage")
        if one.shape is None or a.get_external_count() or a.get_layout() == h5py.h5d.VIRTUAL:
            return  # nothing outside the file is read
        if 0 in one.shape:
            return
        if not is_plain(kind):
            same = all(self._same(one[rows], other[rows]) for rows in slices(one))
        elif a.get_layout() == h5py.h5d.CHUNKED:
            same = same_chunks(one, other)
        else:
            same = one.id.get_storage_size() == other.id.get_storage_size() and all(
                raw_rows(one, rows) == raw_rows(other, rows) for rows in slices(one)
            )
        if not same:
            raise self._differ(place, "values")

    def _same(self, one: Any, other: Any) -> bool:
        """Values as h5py gives them; whether references are the same is seen at the end."""
        if isinstance(one, h5py.Reference):
            self._references.append((one, other))
            return type(one) is type(other) and bool(one) == bool(other)
        if isinstance(one, (np.ndarray, np.void)) and one.dtype.names:
            return one.shape == other.shape and all(
                self._same(one[name], other[name]) for name in one.dtype.names
            )
        if isinstance(one, np.ndarray) and one.dtype.kind == "O":
            pairs = zip(one.reshape(-1).tolist(), other.reshape(-1).tolist())
            return one.shape == other.shape and all(self._same(a, b) for a, b in pairs)
        if isinstance(one, (np.ndarray, np.generic, float)):
            one, other = np.asarray(one), np.asarray(other)
            return one.shape == other.shape and one.tobytes() == other.tobytes()
        return type(one) is type(other) and (one == other or isinstance(one, h5py.Empty))

    def _check_references(self, old, new):
        """They lead to partners; or to what was written anew, which is not compared."""
        for one, other in self._references:
            if not one:
                continue
            item, partner = h5py.h5r.dereference(one, old.id), h5py.h5r.dereference(other, new.id)
            name = text_of(h5py.h5r.get_name(other, new.id) or b"")
            wanted = self._partners.get(h5py.h5o.get_info(item).addr)
            found = h5py.h5o.get_info(partner).addr
            anew = _links(new, [name]).keys() & self._created_links.keys()
            same = bool(anew) if wanted is None else wanted == found
            if wanted is None and self._is_part:  # it leads out of what is compared
                same = same or name == text_of(h5py.h5r.get_name(one, old.id) or b"")
            if isinstance(one, h5py.RegionReference):
                regions = h5py.h5r.get_region(one, old.id), h5py.h5r.get_region(other, new.id)
                a, b = ((r.get_select_npoints(), r.get_select_bounds()) for r in regions)
                same = same and a == b
            if not same:
                raise self._differ(name, "references to it")

    def _differ(self, place, what):
        return not_the_same(self._path, "%s (%s)" % (place, what))


def _links(file: h5py.File, places: Iterable[str]) -> Dict[Tuple[int, str], str]:
    """(address of the group or dataset, last name) -> path; without those that are not there."""
    owners: Dict[str, Any] = {}
    found = {}
    for place in places:
        way, _, name = place.rpartition("/")
        if way not in owners:
            owners[way] = reached(file, way)
        if owners[way] is not None:
            found[_address(owners[way]), name] = place
    return found


def _names(group: h5py.Group) -> Iterator[Tuple[str, bytes]]:
    for key in group.id:
        yield text_of(key), key


def _address(item):
    return h5py.h5o.get_info(item.id).addr


def _attribute_names(owner, but):
    """The names of attributes, without those of which (address of the owner, name) is in but."""
    address, count = _address(owner), h5py.h5a.get_num_attrs(owner.id)
    names = {h5py.h5a.open(owner.id, index=index).name for index in range(count)}
    return {name for name in names if (address, text_of(name)) not in but}


def _extent(item):
    return item.get_space().get_simple_extent_type()
