"""The rooms of each package, from top to bottom: a file may use its own room and those below it.

A layer is a set of rooms that do not use each other. A room is a folder below the package's sources
(C++: src/ and include/<package>/, which have the same rooms; Python: src/<package>/); "" stands for
the files at their top, "bvh/rays" is a room of its own. The top __init__.py of a Python package may
use all. docs/architecture.md says what each room is.
"""

CPP = {
    "mesh_map": [
        {"bindings"},
        {"bvh/device", "collision", "paths", "reconstruction"},
        {"bvh/selection", "distance/obstacles"},
        {"bvh/closest", "bvh/rays", "distance/fast_marching", "mesh/repair"},
        {"bvh/tree", "distance/dijkstra", "mesh"},
        {"base"},
    ],
    "mesh_msgs_hdf5": [
        {"deflate", "polygons", "surface"},
    ],
    "osmesa_harness": [
        {"harness", "shim"},
        {""},  # the public headers, and the main() of render tests
    ],
    "rviz_mesh_plugin": [
        {""},  # the entry points of pluginlib
        {"panel"},
        {"tools"},
        {"tools/measuring", "tools/selection"},
        {"measurement"},
        {"label_editing", "picking"},
        {"displays", "selection"},
        {"mesh_view"},
        {"map_server", "properties"},
        {"navigation", "sources"},
        {"ros_client"},
        {"incoming", "legend", "rendering/labels", "rendering/text"},
        {"conversion", "rendering"},
        {"coloring", "labels", "level_of_detail", "rendering/ogre"},
        {"base", "spatial"},
        {"threads"},
    ],
}

PYTHON = {
    "example_mesh_layer": [{""}],
    "example_mesh_navigation": [{""}],
    "mesh_localization": [
        {"ros"},
        {"node"},
        {"relocalization", "sensing"},
        {"tracking"},
        {""},
    ],
    "mesh_map": [
        {"commands", "ros"},
        {"io", "layers", "reconstruction"},
        {"map"},
        {"scans"},
        {"costs", "distance", "registration"},
        {"geometry"},
        {"spatial"},
        {"spatial/opencl"},
        {"", "base"},
    ],
    "mesh_msgs": [
        {""},  # what others import: arrays, validation, transform, zoo, ...
        {"checks"},
        {"wire", "world"},
    ],
    "mesh_msgs_hdf5": [
        {"commands", "label_manager", "server"},
        {"ros", "validation"},
        {"comparison", "labels"},
        {"formats"},
        {"isolation"},
        {"map_file"},
        {"formats/clouds", "map_file/writing"},
        {"formats/dae", "formats/gltf", "formats/obj", "formats/ply", "map_file/reading"},
        {"formats/base", "map_file/hdf5"},
        {"checks", "files", "processes", "rendering", "verbs"},
        {"", "model"},
    ],
    "mesh_navigation": [
        {"server/ros"},
        {"server", "simulation/ros", "velocity_guard/ros"},
        {"commands", "move_base", "simulation"},
        {"execution", "planners", "recoveries"},
        {"controllers", "surface"},
        {"client", "plugins", "velocity_guard"},
        {"body"},
        {"", "base"},
    ],
    "mesh_tools_test": [
        {"site"},
        {"faults", "screen", "tutorials"},
        {"demo", "localization"},
        {"driving", "layers", "planning", "reconstruction", "spatial"}
        | {"display", "reference", "troubleshooting"},
        {"", "base"},
    ],
    "osmesa_harness": [{""}],
}
