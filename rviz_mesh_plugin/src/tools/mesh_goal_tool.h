#pragma once

#include <string>

#ifndef Q_MOC_RUN
#include "tools/surface_pose_tool.h"
#endif

namespace rviz_mesh_plugin {

/// Publishes a goal on a surface as geometry_msgs/PoseStamped.
class MeshGoalTool : public SurfacePoseTool
{
  Q_OBJECT

 public:
  MeshGoalTool();

 protected:
  std::string publish(PublishedTopic& topic, const geometry_msgs::PoseStamped& pose) override;
};

}  // namespace rviz_mesh_plugin
