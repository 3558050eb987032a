"""The layered mesh map: a triangle mesh, its topology, cost layers, and queries on its surface."""

from pkgutil import extend_path

from mesh_msgs.module_aliases import alias_modules

# In a devel space, _kernels is in another folder; children that multiprocessing spawns look here
# first.
__path__ = extend_path(__path__, __name__)

from mesh_map.base.errors import MeshMapError  # noqa: E402
from mesh_map.map.mesh_map import MeshMap  # noqa: E402
from mesh_map.spatial.spatial_index import SpatialIndex  # noqa: E402

__all__ = ["MeshMap", "MeshMapError", "SpatialIndex"]

# Documented before modules had rooms. The rooms geometry and ros export what these modules did.
_ROOMS = {
    "base": ("cancel", "errors", "parameter", "plugins"),
    "spatial": ("hits", "spatial_index"),
    "geometry": ("normals", "orientation", "radius_pass", "surface", "topology", "walk"),
    "distance": (
        "dijkstra",
        "exact_geodesic",
        "potential_field",
        "surface_path",
        "wave_front",
    ),
    "costs": ("combination", "edge_weights", "layer", "layered_costs", "settings"),
    "layers": ("combination_layer", "file_layer", "threshold_layer"),
    "map": ("attributes", "footprint", "mesh_map", "queries"),
    "io": ("map_messages", "map_parameters", "map_source", "markers"),
    "ros": ("ros_adapter",),
}
alias_modules(
    {
        "mesh_map.%s" % module: "mesh_map.%s.%s" % (room, module)
        for room, modules in _ROOMS.items()
        for module in modules
    }
)
alias_modules(
    {
        "mesh_map.closest_point": "mesh_map.spatial.device_batches",
        "mesh_map.raycast": "mesh_map.spatial.device_batches",
        "mesh_map.dijkstra_field": "mesh_map.distance.dijkstra",
        "mesh_map.front": "mesh_map.distance.obstacle_distance",
        "mesh_map.parameter_server_ros": "mesh_map.ros.parameter_server",
    }
)
