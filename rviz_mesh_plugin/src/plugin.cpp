#include <pluginlib/class_list_macros.hpp>

#include <rviz/display.h>

#include "rviz_mesh_plugin/cluster_label_display.h"
#include "rviz_mesh_plugin/map3d_display.h"
#include "rviz_mesh_plugin/textured_mesh_display.h"

PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::ClusterLabelDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::Map3DDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::TexturedMeshDisplay, rviz::Display)
