"""The layered mesh map: a triangle mesh, its topology, cost layers, and queries on its surface."""

from mesh_map.errors import MeshMapError
from mesh_map.mesh_map import MeshMap
from mesh_map.spatial_index import SpatialIndex

__all__ = ["MeshMap", "MeshMapError", "SpatialIndex"]
