#include <pluginlib/class_list_macros.hpp>

#include <QCoreApplication>

#include <rviz/display.h>
#include <rviz/panel.h>
#include <rviz/tool.h>

#include "displays/cluster_label_display.h"
#include "displays/map3d_display.h"
#include "displays/textured_mesh_display.h"
#include "panel/cluster_label_panel.h"
#include "panel/mesh_navigation_panel.h"
#include "threads/work_thread.h"
#include "tools/cluster_label_tool.h"
#include "tools/mesh_inspect_tool.h"
#include "tools/mesh_measure_tool.h"
#include "tools/surface_pose_tool.h"

namespace {

/// When RViz's application is gone, and with it all displays, but nothing else yet.
const bool threads_end = [] {
  qAddPostRoutine(&rviz_mesh_plugin::WorkThread::joinAll);
  return true;
}();

}  // namespace

PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::ClusterLabelDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::Map3DDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::TexturedMeshDisplay, rviz::Display)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::ClusterLabelPanel, rviz::Panel)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::MeshNavigationPanel, rviz::Panel)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::ClusterLabelTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::MeshGoalTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::MeshInspectTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::MeshMeasureTool, rviz::Tool)
PLUGINLIB_EXPORT_CLASS(rviz_mesh_plugin::MeshPoseEstimateTool, rviz::Tool)
