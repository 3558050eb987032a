"""Names of before, under which programs of others find what has another name or place now."""

import importlib

import pytest

NAMES = {
    "mesh_map": ["MeshMap", "MeshMapError", "SpatialIndex"],
    "mesh_map.attributes": ["Attributes", "MeshAttributes", "face_costs", "vertex_costs"],
    "mesh_map.cancel": ["CancelFlag"],
    "mesh_map.closest_point": ["ClosestPointFinder"],
    "mesh_map.dijkstra": ["Cancelled", "DijkstraField", "DijkstraSolver"],
    "mesh_map.errors": ["Canceled", "Cancelled", "MeshMapError", "PluginError"],
    "mesh_map.exact_geodesic": ["ExactGeodesic"],
    "mesh_map.front": ["ObstacleDistance", "SurfaceFront"],
    "mesh_map.hits": ["NO_FACE", "RayHit", "RayHits", "SurfacePoint", "SurfacePoints"],
    "mesh_map.layer": ["Layer", "LayerResult"],
    "mesh_map.raycast": ["RayCaster"],
    "mesh_map.spatial_index": ["Cancelled", "SpatialIndex"],
    "mesh_map.surface": ["SurfacePoint", "SurfacePoints", "barycentric_coordinates"],
    "mesh_map.surface_path": ["FieldTracer", "SurfacePath"],
    "mesh_map.walk": ["SurfaceWalk", "SurfaceWalker", "WalkEnd"],
    "mesh_map.wave_front": ["Cancelled", "WaveFrontField", "WaveFrontSolver"],
}


@pytest.mark.parametrize("module", sorted(NAMES))
def test_what_was_documented_is_found(module):
    found = importlib.import_module(module)
    assert [name for name in NAMES[module] if not hasattr(found, name)] == []


def test_a_handler_of_the_old_name_catches_what_is_raised():
    from mesh_map.errors import Canceled, Cancelled

    with pytest.raises(Cancelled):
        raise Canceled("stopped")
