#include "sources/mesh_topics.h"

#include <exception>
#include <utility>

#include <boost/shared_ptr.hpp>

#include "incoming/mesh_loader.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t GEOMETRY_QUEUE = 2;
/// A map publishes its layers, textures and labels in bursts, one message each.
constexpr std::uint32_t BURST_QUEUE = 32;
constexpr std::uint32_t LABELS_QUEUE = 1000;
constexpr std::uint32_t FEW_QUEUE = 4;

}  // namespace

MeshTopics::MeshTopics(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader)
    : inbox_(std::move(inbox)), loader_(std::move(loader))
{
}

template <class Message>
std::string MeshTopics::subscribe(Subscription& subscription, ros::NodeHandle& node_handle,
                                  const std::string& topic, std::uint32_t queue,
                                  const TopicReceiver::Callbacks<Message>& callbacks)
{
  try {
    subscription.end();
    if (!topic.empty()) {
      subscription = receiver_.subscribe(node_handle, topic, queue, callbacks);
    }
  } catch (const std::exception& error) {  // a name that is none; no more threads
    return error.what();
  }
  return std::string();
}

template <class Message>
std::string MeshTopics::subscribe(Subscription& subscription, ros::NodeHandle& node_handle,
                                  const std::string& topic, std::uint32_t queue,
                                  Reception InboxContent::*reception)
{
  TopicReceiver::Callbacks<Message> callbacks;
  callbacks.receive = [inbox = inbox_](const boost::shared_ptr<const Message>& message,
                                       const TopicReceiver::Flag& ended) {
    inbox->receive(*message, &ended);
  };
  callbacks.refuse = [inbox = inbox_, reception](const std::string& reason,
                                                 const TopicReceiver::Flag& ended) {
    inbox->refuse(reception, reason, &ended);
  };
  return subscribe(subscription, node_handle, topic, queue, callbacks);
}

std::string MeshTopics::subscribeGeometry(ros::NodeHandle& node_handle, const std::string& topic)
{
  TopicReceiver::Callbacks<mesh_msgs::MeshGeometryStamped> callbacks;
  callbacks.receive = [loader = loader_](const mesh_msgs::MeshGeometryStamped::ConstPtr& message,
                                         const TopicReceiver::Flag& ended) {
    loader->receive(message, &ended);
  };
  callbacks.refuse = [loader = loader_](const std::string& reason,
                                        const TopicReceiver::Flag& ended) {
    loader->refuse(reason, &ended);
  };
  return subscribe(geometry_, node_handle, topic, GEOMETRY_QUEUE, callbacks);
}

std::string MeshTopics::subscribeCosts(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshVertexCostsStamped>(costs_, node_handle, topic, BURST_QUEUE,
                                                      &InboxContent::costs_reception);
}

std::string MeshTopics::subscribeFaceCosts(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshFaceCostsStamped>(face_costs_, node_handle, topic, BURST_QUEUE,
                                                    &InboxContent::face_costs_reception);
}

std::string MeshTopics::subscribeUpdates(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshVertexCostsSparseStamped>(
      updates_, node_handle, topic, BURST_QUEUE, &InboxContent::updates_reception);
}

std::string MeshTopics::subscribeColors(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshVertexColorsStamped>(colors_, node_handle, topic, FEW_QUEUE,
                                                       &InboxContent::colors_reception);
}

std::string MeshTopics::subscribeMaterials(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshMaterialsStamped>(materials_, node_handle, topic, FEW_QUEUE,
                                                    &InboxContent::materials_reception);
}

std::string MeshTopics::subscribeTextures(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshTexture>(textures_, node_handle, topic, BURST_QUEUE,
                                           &InboxContent::textures_reception);
}

std::string MeshTopics::subscribeLabels(ros::NodeHandle& node_handle, const std::string& topic)
{
  return subscribe<mesh_msgs::MeshFaceCluster>(labels_, node_handle, topic, LABELS_QUEUE,
                                               &InboxContent::labels_reception);
}

void MeshTopics::unsubscribe()
{
  for (Subscription* subscription : {&geometry_, &costs_, &face_costs_, &updates_, &colors_,
                                     &materials_, &textures_, &labels_}) {
    subscription->end();
  }
}

}  // namespace rviz_mesh_plugin
