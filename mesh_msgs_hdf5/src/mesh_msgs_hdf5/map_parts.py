"""The parts of a map file."""
from typing import List

from mesh_msgs_hdf5.hdf5_files import reading
from mesh_msgs_hdf5.layouts import find_parts


def parts_of(path: str) -> List[str]:
    """The names of all parts that hold a mesh; "" is the root group. Raises MapFileError."""
    with reading(path) as file:
        return find_parts(file, path)
