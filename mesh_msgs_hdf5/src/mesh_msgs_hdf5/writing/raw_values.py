"""The values of HDF5 objects as they are stored, in pieces that take little memory."""
import math
from typing import Any, Iterator, Tuple

import h5py
import numpy as np

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
