#include "tools/mesh_goal_tool.h"

namespace rviz_mesh_plugin {

MeshGoalTool::MeshGoalTool()
    : SurfacePoseTool({'m', "The goal", "goal", Ogre::ColourValue::Green,
                       PublishedTopic::advertise<geometry_msgs::PoseStamped>})
{
}

std::string MeshGoalTool::publish(PublishedTopic& topic, const geometry_msgs::PoseStamped& pose)
{
  return topic.publish(what(), pose);
}

}  // namespace rviz_mesh_plugin
