"""Numbers in and out of HDF5 datasets, compressed and decompressed on all cores.

What `store` writes has HDF5's own filters (shuffle, deflate), so that every HDF5 reader opens it,
and `load` reads what any HDF5 writer made. Chunks pass HDF5's filter pipeline, which works on one
at a time, and are deflated here (the module _deflate, in C++) where it is built and h5py knows how;
else h5py does it all.
"""
import itertools
import math
from typing import Iterator, List, Optional, Tuple

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
_BATCH_BYTES = 32 << 20  # of numbers whose chunks are held compressed at a time
_PADDING_BYTES = 64 << 20  # that a chunk may have beyond twice the array
_MOST_CHUNKS, _MOST_BYTES = 1 << 16, 1 << 31  # what is more, and larger, is left to HDF5


def store(
    group: h5py.Group,
    name: str,
    array: np.ndarray,
    compression: str = "gzip",
    chunk_rows: Optional[int] = None,
) -> h5py.Dataset:
    """Write an array as a new dataset of the same type and shape.

    array: numbers of any width and byte order, or a structured array; of any layout in memory.
    compression: "gzip" (chunked, shuffle and deflate) or "none" (contiguous). What is empty or a
        single value has nothing to compress and is contiguous.
    chunk_rows: rows of a chunk, which holds whole rows; None for 32768, or for as many as are 1 MiB
        if that is less.

    Errors: ValueError for another compression; whatever h5py raises.
    """
    if compression not in ("gzip", "none"):
        raise ValueError("compression %r is neither gzip nor none" % (compression,))
    array = np.asarray(array)
    if compression == "none" or array.size == 0 or array.ndim == 0:
        return group.create_dataset(name, data=array)
    array = np.ascontiguousarray(array)
    if chunk_rows is None:
        chunk_rows = min(CHUNK_ROWS, _CHUNK_BYTES // (array.nbytes // len(array)))
    chunks = (min(max(1, chunk_rows), len(array)),) + array.shape[1:]
    direct = _deflate is not None and hasattr(h5py.h5d.DatasetID, "write_direct_chunk")
    if not direct or not _is_plain(array.dtype):
        return group.create_dataset(name, data=array, chunks=chunks, **_FILTERS)

    dataset = group.create_dataset(
        name, shape=array.shape, dtype=array.dtype, chunks=chunks, **_FILTERS
    )
    offsets = list(_offsets(array.shape, chunks))
    batch = _batch_length(chunks, array.dtype)
    for first in range(0, len(offsets), batch):
        part = offsets[first : first + batch]
        compressed = _deflate._compress(array, chunks, True, first, len(part))
        for offset, data in zip(part, compressed):
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
    batch: List[Tuple[bytes, int]] = []
    first = 0
    length = _batch_length(dataset.chunks, dataset.dtype)
    try:
        for offset in _offsets(dataset.shape, dataset.chunks):
            skipped, data = dataset.id.read_direct_chunk(offset)
            flags = 0
            for bit, flag in enumerate(filters):
                flags += 0 if skipped >> bit & 1 else flag
            batch.append((data, flags))
            if len(batch) == length:
                _deflate._decompress(batch, dataset.chunks, first, array)
                first += length
                batch = []
        _deflate._decompress(batch, dataset.chunks, first, array)
    except RuntimeError as error:
        raise OSError("%s: %s" % (dataset.name, error)) from error
    return array


def _offsets(shape, chunks) -> Iterator[Tuple[int, ...]]:
    """Where each chunk begins, in the order in which _deflate numbers them."""
    return itertools.product(*map(range, itertools.repeat(0), shape, chunks))


def _batch_length(chunks, dtype) -> int:
    return max(1, _BATCH_BYTES // (math.prod(chunks) * dtype.itemsize))


def _is_plain(dtype):
    """True for numbers whose bytes in the file are those in memory."""
    return dtype.kind in "fiu" and dtype.itemsize <= 8 and dtype.metadata is None


def _direct_filters(dataset) -> List[int]:
    """The flags (of _deflate) of the dataset's filters, in their order.

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
        if code == h5py.h5z.FILTER_SHUFFLE and tuple(values) == (dataset.dtype.itemsize,):
            filters.append(_deflate._SHUFFLED)
        elif code == h5py.h5z.FILTER_DEFLATE:
            filters.append(_deflate._DEFLATED)
        else:
            return []
    if filters not in ([_deflate._DEFLATED], [_deflate._SHUFFLED, _deflate._DEFLATED]):
        return []
    # what was never stored has the fill value
    expected = 1
    for length, side in zip(dataset.shape, dataset.chunks):
        expected *= -(-length // side)
    complete = expected <= _MOST_CHUNKS and identifier.get_num_chunks() == expected
    return filters if complete else []
