"""Carries everything of an HDF5 file into a new one as it is stored, nothing decoded."""
import h5py
import numpy as np

from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import address, join
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

MAX_DEPTH = 200  # HDF5 copies group in group by recursion in C
MAX_OBJECTS = 2_000_000


def check_copyable(path: PathLike, file: h5py.File) -> None:
    """Refuse nesting and numbers of objects that no map has, and names that lead back to the root.

    Codes size and link.
    """
    root = address(file["/"])
    seen = {root}
    groups = [(file["/"], 0)]
    count = 0
    while groups:
        group, depth = groups.pop()
        count += len(group)
        if depth > MAX_DEPTH or count > MAX_OBJECTS:
            raise MapFileError(
                "size",
                path,
                "it has more than %d objects, or groups more than %d deep, first %s"
                % (MAX_OBJECTS, MAX_DEPTH, group.name[:80]),
                "is it a mesh map?",
            )
        for key in group.id:
            if group.id.links.get_info(key).type != h5py.h5l.TYPE_HARD:
                continue
            info = h5py.h5o.get_info(group.id, key)
            if info.type != h5py.h5o.TYPE_GROUP:
                continue
            place = info.fileno, info.addr
            if place == root:
                raise MapFileError(
                    "link",
                    path,
                    "%s leads back to the root" % join(group, key.decode("utf-8", "replace")),
                    "remove that name first",
                )
            if place not in seen:
                seen.add(place)
                groups.append((h5py.Group(h5py.h5o.open(group.id, key)), depth + 1))


def copy_everything(path: PathLike, source: h5py.File, target: h5py.File) -> None:
    """Fill an empty file with all objects, links (not followed) and attributes of another.

    Objects that have several names keep them. Raises MapFileError (size, link) with path.
    """
    check_copyable(path, source)
    everything = b"everything"
    while source.id.links.exists(everything):
        everything += b"_"
    h5py.h5o.copy(source.id, b"/", target.id, everything)
    copied = target[everything]
    for key in list(source["/"].id):  # in its order
        copied.id.links.move(key, target["/"].id, key)
    target.id.unlink(everything)
    copy_attributes(source["/"], target["/"])


def copy_attributes(old: h5py.Group, new: h5py.Group) -> None:
    """Bit for bit, whatever the type: only the type's own way to memory and back is used."""
    for index in range(h5py.h5a.get_num_attrs(old.id)):
        source = h5py.h5a.open(old.id, index=index)
        target = h5py.h5a.create(new.id, source.name, source.get_type(), source.get_space())
        if source.get_space().get_simple_extent_type() != h5py.h5s.NULL:
            values = np.zeros(source.shape, dtype=source.dtype)
            source.read(values)
            target.write(values)
