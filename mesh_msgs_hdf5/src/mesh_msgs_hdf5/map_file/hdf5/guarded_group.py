"""The group of a part, from which only what is safe is read; counts the bytes that are read."""
from typing import Callable, Dict, Iterable, List, Optional, Tuple, Union

import h5py
import numpy as np

from mesh_msgs_hdf5.map_file.hdf5 import chunks
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import (
    MAX_CHILDREN,
    child,
    children,
    default_budget,
    exists,
    first_keys,
    is_dataset_of_this_file,
    is_group_of_this_file,
)
from mesh_msgs_hdf5.map_file.hdf5.hdf5_storage import (
    check_ratio,
    check_storage,
    declared_bytes,
)
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike


_KEPT = 64  # datasets that stay open: what is read, listed and counted is asked for several times


class GuardedGroup:
    """A group of an open file. Places are paths relative to it, like "channels/vertices".

    A link anywhere on the way to a place is refused (code link). What is read through one object
    is bounded in all: a file may name one small dataset many times.

    path: the file, for errors. Attributes: budget (bytes that may be read), tell (is told of names
    that are left out because they are not UTF-8; None: they are refused).
    """

    def __init__(self, path: PathLike, group: h5py.Group) -> None:
        self.path = path
        self.group = group
        self.budget = default_budget()
        self.tell: Optional[Callable[[str], None]] = None
        self._taken = 0
        self._file_bytes = group.file.id.get_filesize()
        self._subgroups: Dict[str, Optional[h5py.Group]] = {}
        self._datasets: Dict[str, h5py.Dataset] = {}

    def subgroup(self, place: str) -> Optional[h5py.Group]:
        """The group at a place; None if there is none."""
        if place not in self._subgroups:
            group: Optional[h5py.Group] = self.group
            for name in place.split("/") if place else ():
                group = child(self.path, group, name)
                if group is None:
                    break
            self._subgroups[place] = group
        return self._subgroups[place]

    def dataset(self, place: str, fields: bool = False) -> Optional[h5py.Dataset]:
        """The dataset of numbers (or, with fields, a compound of them) at a place, safe to read.

        None if there is none.
        """
        found = self._datasets.get(place)
        if found is not None and (fields or not found.dtype.names):
            return found
        way, _, name = place.rpartition("/")
        group = self.subgroup(way)
        found = None if group is None else child(self.path, group, name, h5py.Dataset)
        if found is not None:
            check_storage(self.path, found, self.budget, fields)
            if len(self._datasets) < _KEPT:
                self._datasets[place] = found
        return found

    def first(self, places: Iterable[str]) -> List[str]:
        """The first of the places where there is something, alone; [] if there is none."""
        return [place for place in places if exists(self.group, place)][:1]

    def first_dataset(self, places: Iterable[str]) -> Optional[h5py.Dataset]:
        """The dataset at the first of the places where there is something."""
        found = self.first(places)
        return self.dataset(found[0]) if found else None

    def names(self, place: str, most: int = MAX_CHILDREN) -> List[str]:
        """The names in the group at a place, sorted; [] if there is no group."""
        group = self.subgroup(place)
        return [] if group is None else self.children(group, most)

    def children(self, group: h5py.Group, most: int = MAX_CHILDREN) -> List[str]:
        """The names in a group below, sorted."""
        return children(self.path, group, most, self.tell)

    def dataset_names(self, place: str, most: int = MAX_CHILDREN) -> List[str]:
        """Those of them that are datasets and no links."""
        group = self.subgroup(place)
        names = [] if group is None else self.children(group, most)
        return [name for name in names if is_dataset_of_this_file(group, name)]

    def is_empty(self, place: str) -> bool:
        """True if there is a group at a place with nothing in it, reached without a link."""
        group = self.group
        for step in place.split("/"):
            if not is_group_of_this_file(group, step):
                return False
            group = group[step]
        return not first_keys(group, 1)

    def values(self, found: h5py.Dataset) -> np.ndarray:
        """All of a dataset that was checked, as it is stored; nothing else reads arrays."""
        self._taken += declared_bytes(found)
        self.check_total(self._taken)
        return chunks.load(found)

    def check_total(self, declared: int) -> None:
        """Refuse to read so many bytes of this file."""
        if declared > self.budget:
            raise MapFileError(
                "size",
                self.path,
                "its arrays declare %d bytes, more than the %d allowed" % (declared, self.budget),
                "read them one by one, on a machine with more memory",
            )
        check_ratio(self.path, "all of it", declared, self._file_bytes)


def check_shape(
    path: PathLike,
    found: h5py.Dataset,
    columns: Union[int, Tuple[int, ...]],
    rows: Optional[int] = None,
) -> int:
    """Refuse a dataset that is not [rows, columns] or, in one dimension, [rows * columns].

    columns: one number or, if rows are known, several that may be. Returns the columns. Nothing is
    read.
    """
    shape, size = found.shape, found.size
    for number in columns if isinstance(columns, tuple) else (columns,):
        flat = len(shape) == 1 and size % number == 0
        if (flat or len(shape) == 2 and shape[1] == number) and (
            rows is None or size == rows * number
        ):
            return number
    wanted = "/".join(map(str, columns)) if isinstance(columns, tuple) else columns
    raise MapFileError(
        "shape",
        path,
        "%s has the shape %s, not [%s,%s]"
        % (found.name, list(shape), "N" if rows is None else rows, wanted),
        "is it another mesh's, or in a layout of another program?",
    )
