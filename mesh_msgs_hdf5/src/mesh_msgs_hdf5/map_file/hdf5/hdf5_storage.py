"""Whether what a dataset declares can be read: from this file, by filters we know, in full.

No declared size is believed: HDF5 allocates what a file says, whatever is stored.
"""
import math

import h5py

from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

# an array above this size must not be stored in less than a hundredth of it; deflate makes 1000
# times smaller what is all zeros
RATIO_FREE_BYTES = 256 << 20
MAX_RATIO = 100
# HDF5 allocates a whole chunk, which may be larger than the array in it
_CHUNK_FREE_BYTES = 64 << 20
_MAX_FIELDS = 64
_FILTERS = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32, 32000)
_FOREIGN = "only what is stored in the file itself is read: copy the data into it"
_A_MAP = "is it a mesh map?"


def declared_bytes(dataset: h5py.Dataset) -> int:
    """The bytes that reading all of a dataset takes."""
    return math.prod(dataset.shape) * dataset.dtype.itemsize  # its size is one that overflows


def check_storage(path: PathLike, dataset: h5py.Dataset, budget: int, fields: bool = False) -> None:
    """Refuse a dataset that cannot be read safely and wholly, before any of it is read.

    Codes: external, virtual, filter, dtype (neither numbers nor, with fields, a compound of
    numbers), size.
    """
    properties = dataset.id.get_create_plist()
    if properties.get_external_count():
        raise MapFileError(
            "external", path, "%s is stored in another file" % dataset.name, _FOREIGN
        )
    if properties.get_layout() == h5py.h5d.VIRTUAL:
        raise MapFileError("virtual", path, "%s is a virtual dataset" % dataset.name, _FOREIGN)
    for i in range(properties.get_nfilters()):
        code = properties.get_filter(i)[0]
        if code not in _FILTERS:
            raise MapFileError(
                "filter",
                path,
                "%s is compressed by filter %d, which is not read" % (dataset.name, code),
                "h5repack -f GZIP=1 FILE NEW_FILE, where that filter is installed",
            )
    _check_type(path, dataset, fields)
    declared = declared_bytes(dataset)
    if declared > budget:
        raise MapFileError(
            "size",
            path,
            "%s declares %d bytes, more than the %d allowed" % (dataset.name, declared, budget),
            _A_MAP,
        )
    _check_complete(path, dataset, properties, declared)
    check_ratio(path, dataset.name, declared, dataset.id.get_storage_size())


def check_ratio(path: PathLike, name: str, declared: int, stored: int) -> None:
    """Refuse much that is stored in almost nothing."""
    if declared > RATIO_FREE_BYTES and declared > MAX_RATIO * stored:
        raise MapFileError(
            "size",
            path,
            "%s declares %d bytes, which is %d times what is stored"
            % (name, declared, declared // max(stored, 1)),
            _A_MAP,
        )


def _check_type(path, dataset, fields):
    kind = dataset.id.get_type().get_class()
    numbers = (h5py.h5t.INTEGER, h5py.h5t.FLOAT)
    if dataset.shape is not None and kind in numbers and dataset.dtype.kind in "fiu":
        return
    dtype = dataset.dtype if kind != h5py.h5t.TIME else "times"
    compound = kind == h5py.h5t.COMPOUND and dataset.dtype.names  # not a complex number
    if fields and dataset.shape is not None and compound:
        plain = [dtype[name].kind in "fiu" for name in dtype.names]
        if all(plain) and len(plain) <= _MAX_FIELDS:
            return
    what = "nothing" if dataset.shape is None else dtype
    raise MapFileError("dtype", path, "%s holds %s, not numbers" % (dataset.name, what), "")


def _check_complete(path, dataset, properties, declared):
    """HDF5 gives zeros for what was never stored; a mesh must be stored wholly."""
    if properties.get_layout() == h5py.h5d.CHUNKED:
        chunk_bytes = dataset.dtype.itemsize
        expected = 1
        for length, chunk in zip(dataset.shape, dataset.chunks):
            expected *= -(-length // chunk)
            chunk_bytes *= chunk
        if chunk_bytes > max(_CHUNK_FREE_BYTES, 2 * declared):
            raise MapFileError(
                "size",
                path,
                "%s has chunks of %d bytes for %d bytes of data"
                % (dataset.name, chunk_bytes, declared),
                _A_MAP,
            )
        if hasattr(dataset.id, "get_num_chunks"):
            complete = dataset.id.get_num_chunks() == expected
        else:  # HDF5 before 1.10.5 does not count: at least some must be there
            complete = not expected or dataset.id.get_storage_size() > 0
    else:
        complete = dataset.id.get_storage_size() >= declared
    if not complete:
        raise MapFileError(
            "size",
            path,
            "%s declares %d bytes, but not all of them are stored" % (dataset.name, declared),
            "the file was not written to the end: restore it from a copy",
        )
