#include <pluginlib/class_list_macros.hpp>

#include <rviz/display.h>

#include "rviz_mesh_plugin/textured_mesh_display.h"

PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::TexturedMeshDisplay, rviz::Display)
