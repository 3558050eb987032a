"""Writes objects of a map file, and remembers what it did so that it can be verified."""
from typing import Any, Dict, Iterable, List, Optional, Set, Tuple

import h5py
import numpy as np

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.map_file.hdf5 import chunks
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import join
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_MAX_FIXED_BYTES = 60_000  # HDF5 allows 64 kB for an attribute and what describes it
# what is smaller is contiguous: the index of chunks would take more than deflate saves
SMALL_BYTES = 4096
_SLICE_BYTES = 4 << 20  # that are compared at a time


def check_compression(path: PathLike, compression: str) -> None:
    """Refuse what is neither gzip nor none."""
    if compression not in ("gzip", "none"):
        raise MapFileError(
            "value", path, "compression %r is not known" % (compression,), "gzip or none"
        )


class ObjectWriter:
    """Creates and removes objects in a file that is being built.

    Attributes: path, of the map, for errors. removed, created: absolute paths of objects in the
    file; one that was replaced is in both. moved: old path -> new path. changed: (path, name) of
    attributes that were set or removed. notes: None if an object in the way is refused, else what
    is in the way is renamed, and a sentence about it added.
    """

    def __init__(
        self, path: PathLike, compression: str = "gzip", notes: Optional[List[str]] = None
    ) -> None:
        check_compression(path, compression)
        self.path = path
        self.notes = notes
        self.removed: Set[str] = set()
        self.created: Set[str] = set()
        self.moved: Dict[str, str] = {}
        self.changed: Set[Tuple[str, str]] = set()
        self._compression = compression
        self._arrays: Dict[str, np.ndarray] = {}
        self._names: Dict[str, str] = {}  # a further name -> the one of the array
        self._attributes: Dict[Tuple[str, str], Any] = {}

    def group(self, parent: h5py.Group, name: str) -> h5py.Group:
        """The group of that name, which is made if there is none."""
        if parent.id.links.exists(name.encode("utf-8")):
            if self._is_group(parent, name):
                return parent[name]
            self._make_room(parent, name)
        self.created.add(join(parent, name))
        return parent.create_group(name)

    def array(
        self, group: h5py.Group, name: str, values: np.ndarray, many: bool = False
    ) -> h5py.Dataset:
        """A new dataset. many: one of perhaps thousands, of which the small are not compressed."""
        if group.id.links.exists(name.encode("utf-8")):
            self._make_room(group, name)
        small = many and values.nbytes < SMALL_BYTES
        stored = chunks.store(group, name, values, "none" if small else self._compression)
        place = join(group, name)
        self.created.add(place)
        self._arrays[place] = values
        return stored

    def further_name(self, stored: h5py.Dataset, group: h5py.Group, name: str) -> None:
        """Let an array stand at a second place, too; it is stored once."""
        if group.id.links.exists(name.encode("utf-8")):
            self._make_room(group, name)
        group[name] = stored
        place = join(group, name)
        self.created.add(place)
        self._names[place] = stored.name

    def text(self, owner: Any, name: str, text: str) -> None:
        """Set an attribute: UTF-8 of fixed length.

        Those of variable length lie in a heap, on whose damage HDF5 1.10 loops for ever.
        """
        data = text.encode("utf-8")
        if len(data) > _MAX_FIXED_BYTES:
            self.attribute(owner, name, text)
        else:
            kind = h5py.string_dtype("utf-8", max(1, len(data)))
            self._set(owner, name, np.array(data, dtype=kind), kind)

    def attribute(self, owner: Any, name: str, value: Any) -> None:
        """Set an attribute to an array, or to a text of variable length, as LVR2 wants them."""
        if isinstance(value, str):
            self._set(owner, name, value, h5py.string_dtype())
        else:
            self._set(owner, name, value, value.dtype)

    def c_text(self, owner: Any, name: str, text: str) -> None:
        """Set an attribute to a text as C has it: ASCII, ending with one zero byte."""
        data = text.encode("ascii") + b"\0"
        kind = h5py.h5t.C_S1.copy()
        kind.set_size(len(data))
        kind.set_strpad(h5py.h5t.STR_NULLTERM)
        self.remove_attribute(owner, name)
        space = h5py.h5s.create(h5py.h5s.SCALAR)
        attribute = h5py.h5a.create(owner.id, name.encode("utf-8"), kind, space)
        attribute.write(np.array(data, dtype="S%d" % len(data)), kind)
        self._attributes[owner.name, name] = text

    def _set(self, owner, name, value, dtype):
        self.remove_attribute(owner, name)
        owner.attrs.create(name, value, dtype=dtype)
        self._attributes[owner.name, name] = value

    def remove_attribute(self, owner: Any, name: str) -> None:
        """Remove an attribute, if there is one."""
        self.changed.add((owner.name, name))
        self._attributes.pop((owner.name, name), None)
        if h5py.h5a.exists(owner.id, name.encode("utf-8")):
            h5py.h5a.delete(owner.id, name.encode("utf-8"))

    def remove(self, parent: h5py.Group, name: str) -> bool:
        """Remove a name, if it is there; what has another name too stays under that one."""
        if not parent.id.links.exists(name.encode("utf-8")):
            return False
        parent.id.unlink(name.encode("utf-8"))
        place = join(parent, name)
        self.removed.add(place)
        self.created.discard(place)
        self._arrays.pop(place, None)
        self._names.pop(place, None)
        return True

    def remove_all(self, file: h5py.File, places: Iterable[str]) -> None:
        """Remove objects, and the groups on the way to them that are empty then and say nothing."""
        ways = set()
        for place in sorted(places, key=len, reverse=True):
            way, _, name = place.rpartition("/")
            self.remove(file[way or "/"], name)
            while way:
                ways.add(way)
                way = way.rpartition("/")[0]
        for place in sorted(ways, key=len, reverse=True):
            way, _, name = place.rpartition("/")
            if not len(file[place]) and not len(file[place].attrs):
                self.remove(file[way or "/"], name)

    def move(self, parent: h5py.Group, name: str, to: h5py.Group, new_name: str) -> str:
        """Give an object another place; returns its path."""
        parent.id.links.move(name.encode("utf-8"), to.id, new_name.encode("utf-8"))
        old, new = join(parent, name), join(to, new_name)
        self.moved[old] = new
        self.created.add(new)
        return new

    def _make_room(self, parent, name):
        place = join(parent, name)
        if self.notes is None:
            raise MapFileError(
                "layer",
                self.path,
                "%s is there already, and is something else" % place,
                "choose another name, or rename that one",
            )
        self.note("%s was renamed %s", place, self.move(parent, name, parent, free(parent, name)))

    def note(self, text: str, *values: Any) -> None:
        """Add a sentence to the notes."""
        if self.notes is not None:
            self.notes.append(text % values)

    @staticmethod
    def _is_group(parent, name):
        kind = parent.id.links.get_info(name.encode("utf-8")).type
        return kind == h5py.h5l.TYPE_HARD and isinstance(parent[name], h5py.Group)

    def check_written(self, file: h5py.File) -> None:
        """Refuse a file that does not hold exactly what was written."""
        for place, values in self._arrays.items():
            if not _holds(file[place], values):
                raise not_the_same(self.path, place)
        for place, other in self._names.items():
            if file[place] != file[other]:
                raise not_the_same(self.path, place)
        for (place, name), value in self._attributes.items():
            found = file[place].attrs[name]
            if isinstance(value, str):
                found = found.decode("utf-8") if isinstance(found, bytes) else found
                same = found == value
            else:
                same = np.asarray(found).tobytes() == np.asarray(value).tobytes()
            if not same:
                raise not_the_same(self.path, "attribute %s of %s" % (name, place))


def _holds(dataset: h5py.Dataset, values: np.ndarray) -> bool:
    """True if a dataset is exactly this array; takes little memory besides what it reads."""
    if dataset.dtype != values.dtype or dataset.shape != values.shape:
        return False
    if values.ndim == 0 or not values.size:
        return identical(dataset[()], values)
    stored = chunks.load(dataset) if dataset.chunks else dataset
    step = max(1, _SLICE_BYTES // (values.nbytes // len(values)))
    pieces = (slice(start, start + step) for start in range(0, len(values), step))
    return all(identical(stored[piece], values[piece]) for piece in pieces)


def free(parent: h5py.Group, name: str) -> str:
    """The name, or the first of name (2), name (3), ... that is not there yet."""
    number = 1
    new = name
    while parent.id.links.exists(new.encode("utf-8")):
        number += 1
        new = "%s (%d)" % (name, number)
    return new


def not_the_same(path: PathLike, what: str) -> MapFileError:
    """The error if a new file is not what it should be."""
    return MapFileError(
        "save",
        path,
        "the new file does not read back as what was to be saved: %s" % what,
        "nothing was changed; report this",
    )
