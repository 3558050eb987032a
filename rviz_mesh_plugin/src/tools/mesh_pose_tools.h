#pragma once

#include <array>
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

/// Publishes where a robot is on a surface as geometry_msgs/PoseWithCovarianceStamped.
class MeshPoseEstimateTool : public SurfacePoseTool
{
  Q_OBJECT

 public:
  MeshPoseEstimateTool();

 protected:
  std::string publish(PublishedTopic& topic, const geometry_msgs::PoseStamped& pose) override;

 private:
  /// x, y, z in m², and about these axes of the frame of the pose in rad².
  std::array<rviz::FloatProperty*, 6> covariance_{};
};

}  // namespace rviz_mesh_plugin
