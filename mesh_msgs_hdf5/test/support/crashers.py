"""Writes map files on which libhdf5 1.10 crashes or never ends."""
import struct

import h5py

from mesh_msgs_hdf5.map_file import MapFile

# what the size of the text becomes; 16 is added to find the next text, so that 2^64 - 16 leads back
LIES = {"crash": 1 << 40, "loop": (1 << 64) - 16}


def write_crasher(path, mesh, kind):
    """A map whose text frame_id is in a heap of variable-length texts, with a size that lies."""
    MapFile.write(path, mesh)
    with h5py.File(path, "r+") as file:
        del file["mesh"].attrs["frame_id"]
        file["mesh"].attrs["frame_id"] = "a_frame_of_variable_length"
    data = bytearray(path.read_bytes())
    start = data.find(b"a_frame_of_variable_length\0") - 8
    if start < 0:
        start = data.index(b"a_frame_of_variable_length") - 8
    data[start : start + 8] = struct.pack("<Q", LIES[kind])
    path.write_bytes(data)
