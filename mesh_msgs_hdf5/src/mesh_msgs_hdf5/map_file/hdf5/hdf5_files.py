"""The only place that opens a user's HDF5 file; see hdf5_stream for those that are being built."""
import contextlib
from typing import Iterator

import h5py

from mesh_msgs_hdf5.files.probe import check_regular, kind_of, read_head
from mesh_msgs_hdf5.map_file.hdf5.hdf5_guard import HDF5_ERRORS, is_locked, translated
from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

# h5py before 3.5 cannot choose; with it a file on a disk without locks still opens
_LOCKING = {"locking": "best-effort"} if h5py.version.version_tuple[:2] >= (3, 5) else {}


@contextlib.contextmanager
def reading(path: PathLike) -> Iterator[h5py.File]:
    """An h5py.File of a user's map, read only; every error inside becomes a MapFileError."""
    check_regular(path)
    try:
        opened = h5py.File(path, "r", **_LOCKING)
    except HDF5_ERRORS as error:
        if not is_locked(error):
            _check_format(path)
        raise translated(path, error) from error
    try:
        with opened as file:
            yield file
    except HDF5_ERRORS as error:
        raise translated(path, error) from error


def _check_format(path):
    """Refuse, with a better error than HDF5's, what is none of its files."""
    head = read_head(path)
    kind = kind_of(path, head)
    if kind in ("ply", "obj", "stl", "off", "dae", "glb", "gltf"):
        raise MapFileError(
            "format",
            path,
            "it is a %s file, not an HDF5 map" % kind.upper(),
            "rosrun mesh_msgs_hdf5 mesh_tool import FILE.%s FILE.h5" % kind,
        )
    if not h5py.is_hdf5(path) and not head.startswith(b"\x89HDF"):
        raise MapFileError(
            "format", path, "it is not an HDF5 file", "maps are made by: mesh_tool import"
        )
