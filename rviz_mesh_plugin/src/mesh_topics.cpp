#include "rviz_mesh_plugin/mesh_topics.h"

#include <utility>

#include <ros/exceptions.h>
#include <boost/function.hpp>
#include <boost/shared_ptr.hpp>

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t GEOMETRY_QUEUE = 2;
/// A map publishes its layers in one burst, one message each.
constexpr std::uint32_t COSTS_QUEUE = 32;
constexpr std::uint32_t COLORS_QUEUE = 4;

template <class Message>
std::string subscribe(ros::Subscriber& subscriber, ros::NodeHandle& node_handle,
                      const std::string& topic, std::uint32_t queue,
                      const std::shared_ptr<MeshInbox>& inbox)
{
  subscriber.shutdown();  // waits for a callback that is running
  if (topic.empty()) {
    return std::string();
  }
  const boost::function<void(const boost::shared_ptr<const Message>&)> callback =
      [inbox](const boost::shared_ptr<const Message>& message) { inbox->receive(*message); };
  try {
    subscriber = node_handle.subscribe<Message>(topic, queue, callback);
  } catch (const ros::Exception& error) {
    return error.what();
  }
  return std::string();
}

}  // namespace

MeshTopics::MeshTopics(std::shared_ptr<MeshInbox> inbox) : inbox_(std::move(inbox)) {}

std::string MeshTopics::subscribeGeometry(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshGeometryStamped>(geometry_, node_handle, topic, GEOMETRY_QUEUE,
                                                   inbox_);
}

std::string MeshTopics::subscribeCosts(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshVertexCostsStamped>(costs_, node_handle, topic, COSTS_QUEUE,
                                                      inbox_);
}

std::string MeshTopics::subscribeColors(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshVertexColorsStamped>(colors_, node_handle, topic, COLORS_QUEUE,
                                                       inbox_);
}

void MeshTopics::unsubscribe()
{
  geometry_.shutdown();
  costs_.shutdown();
  colors_.shutdown();
}

}  // namespace rviz_mesh_plugin
