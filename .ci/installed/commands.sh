#!/usr/bin/env bash
# The commands, a mesh imported and drawn, the plugins that are found: what README.md says, without sourcing anything.
set -euo pipefail
cd "$(mktemp -d)"
rosrun mesh_msgs_hdf5 mesh_tool --help | grep -q ' render '
test -f "$(rospack find mesh_msgs_hdf5)/README.md" # where --help says that more is told
rosrun mesh_msgs_hdf5 mesh_tool --completion | bash -n
rosrun mesh_navigation plan --help >plan.txt
rosrun mesh_navigation go_to --help >go_to.txt
rosrun mesh_msgs_hdf5 mesh_tool refine --help >refine.txt  # a verb of mesh_map
cat >hill.obj <<'OBJ'
v 0 0 0
v 4 0 0
v 4 4 0
v 0 4 0
v 2 2 1
f 1 2 5
f 2 3 5
f 3 4 5
f 4 1 5
OBJ
rosrun mesh_msgs_hdf5 mesh_tool import hill.obj hill.h5
rosrun mesh_msgs_hdf5 mesh_tool render hill.h5 hill.png
head -c 4 hill.png | grep -q PNG
rosmsg show mesh_msgs/MeshGeometry | grep -q vertex_normals
rosmsg show mbf_msgs/GetPathGoal | grep -q planner
rossrv show label_manager/GetLabelGroups >groups.txt
for name in rviz_mesh_plugin rviz_map_plugin; do
  rospack plugins --attrib=plugin rviz | grep -x "$name /usr/share/$name/plugin_description.xml"
done
rospack plugins --attrib=plugin mesh_navigation | grep planners.xml
python3 - <<'PYTHON'
from mesh_map.base.plugins import find_class, plugin_names

names = plugin_names("mesh_map", "mesh_map::Layer")
for name in ("mesh_layers/LabelLayer", "example_mesh_layer/SmoothLayer", "mesh_layers/HeightDiffLayer"):
    print(name, find_class("mesh_map", "mesh_map::Layer", name))
    assert name in names, names
PYTHON
