"""Map files read in processes of their own: whatever is in the file, this process goes on."""
from mesh_msgs_hdf5.isolation.isolated_map_file import (
    DEFAULT_TIMEOUT,
    FUNCTIONS,
    IsolatedMapFile,
    isolated,
)

__all__ = [
    "DEFAULT_TIMEOUT",
    "FUNCTIONS",
    "IsolatedMapFile",
    "isolated",
]
