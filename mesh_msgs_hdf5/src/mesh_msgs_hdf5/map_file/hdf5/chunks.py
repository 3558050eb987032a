"""Numbers in and out of HDF5 datasets, compressed and decompressed on all cores.

What `store` writes has HDF5's own filters (shuffle, deflate), so that every HDF5 reader opens it,
and `load` reads what any HDF5 writer made. Chunks pass HDF5's filter pipeline, which works on one
at a time, and are deflated here (the module _deflate, in C++) where it is built and h5py knows how;
else h5py does it all.
"""
import itertools
import math
from typing import Any, Iterator, List, Tuple

import h5py
import numpy as np

try:
    from mesh_msgs_hdf5 import _deflate
except ImportError:
    _deflate = None

# rows of a chunk: small enough to read a part of an array without the rest, large enough to
# compress as well as one big chunk
CHUNK_ROWS = 32768
_CHUNK_BYTES = 1 << 20  # at most, of an array with wide rows: an image; HDF5's chunk cache is 1 MiB
# deflate is read by every HDF5; levels above 1 cost time and gain 1 %
_FILTERS = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
_SHUFFLE, _DEFLATE = h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_DEFLATE
_BATCH_BYTES = 32 << 20  # of numbers whose chunks are held compressed at a time
_PADDING_BYTES = 64 << 20  # that a chunk may have beyond twice the array
_MOST_CHUNKS, _MOST_BYTES = 1 << 16, 1 << 31  # what is more, and larger, is left to HDF5


def store(
    group: h5py.Group, name: str, array: np.ndarray, compression: str = "gzip"
) -> h5py.Dataset:
    """Write an array as a new dataset of the same type and shape.

    array: numbers of any width and byte order, or a structured array; of any layout in memory.
    compression: "gzip" (chunked, shuffle and deflate) or "none" (contiguous). What is empty or a
        single value has nothing to compress and is contiguous. A chunk holds whole rows: 32768, or
        as many as are 1 MiB if that is less.

    Errors: ValueError for another compression; whatever h5py raises.
    """
    if compression not in ("gzip", "none"):
        raise ValueError("compression %r is neither gzip nor none" % (compression,))
    array = np.asarray(array)
    if compression == "none" or array.size == 0 or array.ndim == 0:
        return group.create_dataset(name, data=array)
    array = np.ascontiguousarray(array)
    rows = min(CHUNK_ROWS, _CHUNK_BYTES // (array.nbytes // len(array)))
    chunks = (min(max(1, rows), len(array)),) + array.shape[1:]
    direct = _deflate is not None and hasattr(h5py.h5d.DatasetID, "write_direct_chunk")
    if not direct or not _is_plain(array.dtype):
        return group.create_dataset(name, data=array, chunks=chunks, **_FILTERS)

    dataset = group.create_dataset(
        name, shape=array.shape, dtype=array.dtype, chunks=chunks, **_FILTERS
    )
    for batch in _batches(dataset):
        whole = [_padded(array[window], chunks) for _, window in batch]
        for (offset, _), data in zip(batch, _deflate._compress(whole)):
            dataset.id.write_direct_chunk(offset, data)
    return dataset


def load(dataset: h5py.Dataset) -> np.ndarray:
    """Read all of a dataset into a new array: exactly what dataset[()] gives, but faster.

    The dataset has to be one that may be read (GuardedGroup.dataset). Every chunk has to hold
    exactly its bytes, with the right checksum.

    Errors: OSError naming the dataset and the chunk that is damaged; ValueError if chunks are far
    larger than the array; whatever h5py raises.
    """
    if dataset.chunks:  # a whole chunk needs memory, however little of it is in the array
        chunk = math.prod(dataset.chunks) * dataset.dtype.itemsize
        whole = math.prod(dataset.shape) * dataset.dtype.itemsize
        if chunk > 2 * whole + _PADDING_BYTES:
            raise ValueError(
                "%s: chunks of %d bytes for an array of %d bytes" % (dataset.name, chunk, whole)
            )
    filters = _direct_filters(dataset)
    if not filters:
        return dataset[()]
    array = np.zeros(dataset.shape, dataset.dtype)
    first = 0
    for batch in _batches(dataset):
        stored, in_part = [], []
        for offset, window in batch:
            skipped, data = dataset.id.read_direct_chunk(offset)
            deflated = not skipped >> filters.index(_DEFLATE) & 1
            shuffled = _SHUFFLE in filters and not skipped & 1
            chunk = part = array[window]
            if part.shape != dataset.chunks or not part.flags.c_contiguous:
                chunk = np.zeros(dataset.chunks, array.dtype)
                in_part.append((part, chunk))
            stored.append((data, shuffled, deflated, chunk))
        try:
            _deflate._decompress(stored, first)
        except RuntimeError as error:
            raise OSError("%s: %s" % (dataset.name, error)) from error
        for part, chunk in in_part:
            part[...] = chunk[tuple(map(slice, part.shape))]
        first += len(batch)
    return array


def _padded(part, chunks):
    """A whole chunk of which that part is in the array; as HDF5 does, zeros are added."""
    if part.shape == chunks:
        return np.ascontiguousarray(part)
    padded = np.zeros(chunks, part.dtype)
    padded[tuple(map(slice, part.shape))] = part
    return padded


def _batches(dataset: h5py.Dataset) -> Iterator[List[Tuple[Any, Any]]]:
    """(where it begins, its window in the array) of each chunk, in C order; in lists of some
    _BATCH_BYTES of chunks.
    """
    starts, slices = [], []
    for length, side in zip(dataset.shape, dataset.chunks):
        starts.append(range(0, length, side))
        slices.append(map(slice, starts[-1], itertools.count(side, side)))
    chunks = zip(itertools.product(*starts), itertools.product(*slices))
    length = max(1, _BATCH_BYTES // (math.prod(dataset.chunks) * dataset.dtype.itemsize))
    while True:
        batch = list(itertools.islice(chunks, length))
        if not batch:
            return
        yield batch


def _is_plain(dtype):
    """True for numbers whose bytes in the file are those in memory."""
    return dtype.kind in "fiu" and dtype.itemsize <= 8 and dtype.metadata is None


def _direct_filters(dataset) -> List[int]:
    """The codes of the dataset's filters, in their order.

    Empty if anything about the dataset is such that HDF5 has to read it.
    """
    identifier = dataset.id
    if (
        _deflate is None
        or not hasattr(identifier, "read_direct_chunk")
        or not hasattr(identifier, "get_num_chunks")
        or not dataset.chunks
        or 0 in dataset.shape
        or math.prod(dataset.chunks) * dataset.dtype.itemsize > _MOST_BYTES
        or not _is_plain(dataset.dtype)
        or identifier.get_type() != h5py.h5t.py_create(dataset.dtype)
    ):
        return []
    filters = []
    properties = identifier.get_create_plist()
    for index in range(properties.get_nfilters()):
        code, _, values, _ = properties.get_filter(index)
        if code == _SHUFFLE and tuple(values) != (dataset.dtype.itemsize,):
            return []
        filters.append(code)
    if filters not in ([_DEFLATE], [_SHUFFLE, _DEFLATE]):
        return []
    # what was never stored has the fill value
    starts = map(range, itertools.repeat(0), dataset.shape, dataset.chunks)
    expected = math.prod(map(len, starts))
    complete = expected <= _MOST_CHUNKS and identifier.get_num_chunks() == expected
    return filters if complete else []
