"""The geometry of a mesh: topology, normals, orientation, what is around a vertex, and walks."""

from mesh_map.geometry.mesh_geometry import MeshGeometry

__all__ = ["MeshGeometry"]
