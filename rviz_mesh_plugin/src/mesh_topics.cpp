#include "rviz_mesh_plugin/mesh_topics.h"

#include <utility>

#include <ros/exceptions.h>
#include <boost/function.hpp>
#include <boost/shared_ptr.hpp>

#include "rviz_mesh_plugin/mesh_loader.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t GEOMETRY_QUEUE = 2;
/// A map publishes its layers, textures and labels in bursts, one message each.
constexpr std::uint32_t BURST_QUEUE = 32;
constexpr std::uint32_t LABELS_QUEUE = 1000;
constexpr std::uint32_t FEW_QUEUE = 4;

/// Messages of publishers in this process arrive without a copy.
template <class Message, class Receive>
std::string subscribe(ros::Subscriber& subscriber, ros::NodeHandle& node_handle,
                      const std::string& topic, std::uint32_t queue, const Receive& receive)
{
  subscriber.shutdown();  // waits for a callback that is running
  if (topic.empty()) {
    return std::string();
  }
  const boost::function<void(const boost::shared_ptr<const Message>&)> callback = receive;
  try {
    subscriber = node_handle.subscribe<Message>(topic, queue, callback);
  } catch (const ros::Exception& error) {
    return error.what();
  }
  return std::string();
}

template <class Message>
std::string subscribe(ros::Subscriber& subscriber, ros::NodeHandle& node_handle,
                      const std::string& topic, std::uint32_t queue,
                      const std::shared_ptr<MeshInbox>& inbox)
{
  return subscribe<Message>(
      subscriber, node_handle, topic, queue,
      [inbox](const boost::shared_ptr<const Message>& message) { inbox->receive(*message); });
}

}  // namespace

MeshTopics::MeshTopics(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader)
    : inbox_(std::move(inbox)), loader_(std::move(loader))
{
}

std::string MeshTopics::subscribeGeometry(ros::NodeHandle& node_handle, const std::string& topic)
{
  using Message = mesh_msgs::MeshGeometryStamped;
  return subscribe<Message>(
      geometry_, node_handle, topic, GEOMETRY_QUEUE,
      [loader = loader_](const Message::ConstPtr& message) { loader->receive(message); });
}

std::string MeshTopics::subscribeCosts(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshVertexCostsStamped>(costs_, node_handle, topic, BURST_QUEUE,
                                                      inbox_);
}

std::string MeshTopics::subscribeFaceCosts(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshFaceCostsStamped>(face_costs_, node_handle, topic, BURST_QUEUE,
                                                    inbox_);
}

std::string MeshTopics::subscribeUpdates(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshVertexCostsSparseStamped>(updates_, node_handle, topic,
                                                            BURST_QUEUE, inbox_);
}

std::string MeshTopics::subscribeColors(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshVertexColorsStamped>(colors_, node_handle, topic, FEW_QUEUE,
                                                       inbox_);
}

std::string MeshTopics::subscribeMaterials(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshMaterialsStamped>(materials_, node_handle, topic, FEW_QUEUE,
                                                    inbox_);
}

std::string MeshTopics::subscribeTextures(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshTexture>(textures_, node_handle, topic, BURST_QUEUE, inbox_);
}

std::string MeshTopics::subscribeLabels(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshFaceCluster>(labels_, node_handle, topic, LABELS_QUEUE, inbox_);
}

void MeshTopics::unsubscribe()
{
  for (ros::Subscriber* subscriber : {&geometry_, &costs_, &face_costs_, &updates_, &colors_,
                                      &materials_, &textures_, &labels_}) {
    subscriber->shutdown();
  }
}

}  // namespace rviz_mesh_plugin
