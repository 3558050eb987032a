"""The layered mesh map: a triangle mesh, its topology, cost layers, and queries on its surface."""

from pkgutil import extend_path

# In a devel space, _kernels is in another folder; children that multiprocessing spawns look here
# first.
__path__ = extend_path(__path__, __name__)

from mesh_map.errors import MeshMapError  # noqa: E402
from mesh_map.mesh_map import MeshMap  # noqa: E402
from mesh_map.spatial_index import SpatialIndex  # noqa: E402

__all__ = ["MeshMap", "MeshMapError", "SpatialIndex"]
