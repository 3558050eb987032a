#include "mesh_view/frame_pose.h"

#include <ros/time.h>
#include <rviz/frame_manager.h>
#include <rviz/validate_floats.h>

namespace rviz_mesh_plugin {

std::optional<FramePose> findPose(rviz::FrameManager& frames, const std::string& frame,
                                  const std::string& what, StatusLine& line)
{
  FramePose pose;
  const bool known = frames.getTransform(frame, ros::Time(), pose.position, pose.orientation);
  if (known && rviz::validateFloats(pose.position) && rviz::validateFloats(pose.orientation)) {
    pose.orientation.normalise();
    line = StatusLine::ok("frame '", frame, "' is known in the fixed frame '",
                          frames.getFixedFrame(), "'");
    return pose;
  }
  std::string reason = "the transform contains NaN or infinity";
  if (!known && !frames.transformHasProblems(frame, ros::Time(), reason)) {
    reason = "nobody publishes it yet";
  }
  line = StatusLine::error("no transform from frame '", frame, "' to the fixed frame '",
                           frames.getFixedFrame(), "', ", what, " hidden until then: ", reason);
  return std::nullopt;
}

}  // namespace rviz_mesh_plugin
