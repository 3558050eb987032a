#include <pluginlib/class_list_macros.hpp>

#include <rviz/display.h>
#include <rviz/panel.h>
#include <rviz/tool.h>

#include "rviz_mesh_plugin/cluster_label_display.h"
#include "rviz_mesh_plugin/cluster_label_panel.h"
#include "rviz_mesh_plugin/cluster_label_tool.h"
#include "rviz_mesh_plugin/map3d_display.h"
#include "rviz_mesh_plugin/mesh_goal_tool.h"
#include "rviz_mesh_plugin/mesh_inspect_tool.h"
#include "rviz_mesh_plugin/mesh_pose_estimate_tool.h"
#include "rviz_mesh_plugin/textured_mesh_display.h"

PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::ClusterLabelDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::Map3DDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::TexturedMeshDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::ClusterLabelPanel, rviz::Panel)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::ClusterLabelTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::MeshGoalTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::MeshInspectTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::MeshPoseEstimateTool, rviz::Tool)
