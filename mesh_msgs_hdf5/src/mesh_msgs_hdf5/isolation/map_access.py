"""How the nodes open map files; the one place that says so: in processes of their own."""
from typing import List

from mesh_msgs_hdf5.isolation.isolated_map_file import IsolatedMapFile, isolated
from mesh_msgs_hdf5.model.errors import PathLike

open_map = IsolatedMapFile


def list_parts(path: PathLike) -> List[str]:
    """The names of all parts of a map file; "" is the root group. Raises MapFileError."""
    return isolated("parts", path)
