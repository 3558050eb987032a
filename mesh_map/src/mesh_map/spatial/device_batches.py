"""SpatialIndex.on_device() under the names that it had in releases before."""

from mesh_map.spatial.spatial_index import SpatialIndex

RayCaster = ClosestPointFinder = SpatialIndex.on_device  # of (index, device=None)
