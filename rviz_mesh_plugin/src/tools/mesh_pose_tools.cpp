#include "tools/mesh_pose_tools.h"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <rviz/properties/float_property.h>

namespace rviz_mesh_plugin {
namespace {

struct Variance
{
  const char* name;
  float value;
  const char* description;
};

constexpr float FIFTEEN_DEGREES = 0.2617993878f;

constexpr Variance VARIANCES[6] = {
    {"Covariance x", 0.25f, "Of the position along x of the frame, in m²."},
    {"Covariance y", 0.25f, "Of the position along y of the frame, in m²."},
    {"Covariance z", 0.01f, "Of the position along z of the frame, in m²."},
    {"Covariance roll", 0.01f, "Of the rotation about x of the frame, in rad²."},
    {"Covariance pitch", 0.01f, "Of the rotation about y of the frame, in rad²."},
    {"Covariance yaw", FIFTEEN_DEGREES* FIFTEEN_DEGREES,
     "Of the rotation about z of the frame, in rad²."}};

}  // namespace

MeshGoalTool::MeshGoalTool()
    : SurfacePoseTool({'m', "The goal", "goal", Ogre::ColourValue::Green,
                       PublishedTopic::advertise<geometry_msgs::PoseStamped>})
{
}

std::string MeshGoalTool::publish(PublishedTopic& topic, const geometry_msgs::PoseStamped& pose)
{
  return topic.publish(what(), pose);
}

MeshPoseEstimateTool::MeshPoseEstimateTool()
    : SurfacePoseTool({'e', "The pose estimate", "initialpose", Ogre::ColourValue::Red,
                       PublishedTopic::advertise<geometry_msgs::PoseWithCovarianceStamped>})
{
  for (unsigned i = 0; i < 6; ++i) {
    const Variance& variance = VARIANCES[i];
    covariance_[i] = new rviz::FloatProperty(variance.name, variance.value, variance.description,
                                             getPropertyContainer());
    covariance_[i]->setMin(0.0f);
  }
}

std::string MeshPoseEstimateTool::publish(PublishedTopic& topic,
                                          const geometry_msgs::PoseStamped& pose)
{
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = pose.header;
  message.pose.pose = pose.pose;
  for (unsigned i = 0; i < 6; ++i) {
    message.pose.covariance[7 * i] = covariance_[i]->getFloat();
  }
  return topic.publish(what(), message);
}

}  // namespace rviz_mesh_plugin
