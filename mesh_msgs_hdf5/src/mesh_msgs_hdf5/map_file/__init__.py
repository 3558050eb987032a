"""The map file: one mesh with everything that is known about it, in one HDF5 file."""
from mesh_msgs_hdf5.map_file.map_file import MapFile

__all__ = ["MapFile"]
