"""LZF unpacked by the filter that h5py brings along."""
import h5py
import numpy as np

from mesh_msgs_hdf5.model.errors import MapFileError, PathLike

_LARGEST = (1 << 32) - 1  # of a chunk


def unpacked(path: PathLike, data: bytes, size: int) -> np.ndarray:
    """(size,) uint8 that LZF has packed as data. Raises MapFileError (damaged)."""
    if size == len(data):  # some store what cannot be made smaller as it is
        return np.frombuffer(data, np.uint8)
    damaged = MapFileError("damaged", path, "its compressed points cannot be unpacked", "")
    if not 0 < size < _LARGEST:
        raise damaged
    with h5py.File("lzf", "w", driver="core", backing_store=False) as file:
        dataset = file.create_dataset(
            "data", (size,), np.uint8, chunks=(size,), compression="lzf", shuffle=False
        )
        dataset.id.write_direct_chunk((0,), data)
        try:
            return dataset[()]
        except OSError as error:
            raise damaged from error
