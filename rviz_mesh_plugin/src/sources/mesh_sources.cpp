#include "sources/mesh_sources.h"

#include <exception>
#include <type_traits>

#include <ros/message_traits.h>
#include <boost/shared_ptr.hpp>

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t GEOMETRY_QUEUE = 2;
/// A map publishes its layers, textures and labels in bursts, one message each.
constexpr std::uint32_t BURST_QUEUE = 32;
constexpr std::uint32_t LABELS_QUEUE = 1000;
constexpr std::uint32_t FEW_QUEUE = 4;

}  // namespace

/// How a part of a mesh comes.
struct MeshSources::Channel
{
  const char* type;
  void (MeshSources::*subscribe)(ros::NodeHandle& node_handle, MeshMember part);
};

template <class Message, std::uint32_t queue_size>
void MeshSources::subscribe(ros::NodeHandle& node_handle, MeshMember part)
{
  using Flag = TopicReceiver::Flag;
  TopicReceiver::Callbacks<Message> callbacks;
  if constexpr (std::is_same_v<Message, mesh_msgs::MeshGeometryStamped>) {
    callbacks.receive = [loader = loader_](const auto& message, const Flag& ended) {
      loader->receive(message, &ended);
    };
    callbacks.refuse = [loader = loader_](const std::string& reason, const Flag& ended) {
      loader->refuse(reason, &ended);
    };
  } else {
    callbacks.receive = [queue = queue_](const auto& message, const Flag& ended) {
      queue->receive(*message, &ended);
    };
    callbacks.refuse = [queue = queue_, part](const std::string& reason, const Flag& ended) {
      queue->refuse(part, reason, &ended);
    };
  }
  Topic& topic = topics_[part];
  topic.subscription = receiver_.subscribe(node_handle, topic.name, queue_size, callbacks);
}

const MeshSources::Channel& MeshSources::channel(MeshMember part)
{
  using namespace mesh_msgs;
  using ros::message_traits::datatype;
  static const PerMember<Channel> channels = [] {
    PerMember<Channel> all;
    all[MeshMember::GEOMETRY] = {datatype<MeshGeometryStamped>(),
                                 &MeshSources::subscribe<MeshGeometryStamped, GEOMETRY_QUEUE>};
    all[MeshMember::COSTS] = {datatype<MeshVertexCostsStamped>(),
                              &MeshSources::subscribe<MeshVertexCostsStamped, BURST_QUEUE>};
    all[MeshMember::FACE_COSTS] = {datatype<MeshFaceCostsStamped>(),
                                   &MeshSources::subscribe<MeshFaceCostsStamped, BURST_QUEUE>};
    all[MeshMember::UPDATES] = {datatype<MeshVertexCostsSparseStamped>(),
                                &MeshSources::subscribe<MeshVertexCostsSparseStamped, BURST_QUEUE>};
    all[MeshMember::COLORS] = {datatype<MeshVertexColorsStamped>(),
                               &MeshSources::subscribe<MeshVertexColorsStamped, FEW_QUEUE>};
    all[MeshMember::MATERIALS] = {datatype<MeshMaterialsStamped>(),
                                  &MeshSources::subscribe<MeshMaterialsStamped, FEW_QUEUE>};
    all[MeshMember::TEXTURES] = {datatype<MeshTexture>(),
                                 &MeshSources::subscribe<MeshTexture, BURST_QUEUE>};
    // Each message is one label as it is now.
    all[MeshMember::LABELS] = {datatype<MeshFaceCluster>(),
                               &MeshSources::subscribe<MeshFaceCluster, LABELS_QUEUE>};
    return all;
  }();
  return channels[part];
}

const char* MeshSources::type(MeshMember part)
{
  return channel(part).type;
}

MeshSources::MeshSources(bool with_layouts)
    : queue_(std::make_shared<AttributeQueue>()),
      loader_(std::make_shared<MeshLoader>(with_layouts)),
      services_(queue_, loader_)
{
}

std::vector<MeshMember> MeshSources::connect(ros::NodeHandle& node_handle, const Names& names)
{
  services_.setNames(names.services);
  PerMember<std::string> services;
  services[MeshMember::COLORS] = names.services.colors;
  services[MeshMember::MATERIALS] = names.services.materials;
  services[MeshMember::TEXTURES] = names.services.texture;
  PerMember<bool> renamed;
  for (const MeshMember part : MESH_MEMBERS) {
    renamed[part] =
        topics_[part].name != names.topics[part] || topics_[part].service != services[part];
  }
  // Textures are asked for with their materials.
  renamed[MeshMember::MATERIALS] = renamed[MeshMember::TEXTURES] =
      renamed[MeshMember::MATERIALS] || renamed[MeshMember::TEXTURES];
  std::vector<MeshMember> forgotten;
  for (const MeshMember part : MESH_MEMBERS) {
    if (renamed[part]) {
      forgotten.push_back(part);
    }
  }
  if (!forgotten.empty()) {
    services_.cancel();  // first: what they bring may be among it
  }
  for (const MeshMember part : MESH_MEMBERS) {
    Topic& topic = topics_[part];
    if (renamed[part]) {
      topic.subscription.end();
      topic.subscribed = false;
      forget(part);
    }
    if (!topic.subscribed) {
      topic.name = names.topics[part];
      topic.service = services[part];
      topic.error.clear();
      topic.resolved.clear();
      try {
        if (!topic.name.empty()) {
          (this->*channel(part).subscribe)(node_handle, part);
          topic.resolved = node_handle.resolveName(topic.name);
        }
      } catch (const std::exception& error) {  // a name that is none; no more threads
        topic.error = error.what();
      }
      topic.subscribed = true;
    }
  }
  return forgotten;
}

void MeshSources::forget(MeshMember part)
{
  if (part == MeshMember::GEOMETRY) {
    loader_->clear();
  }
  queue_->forget(part);
}

void MeshSources::disconnect()
{
  services_.cancel();
  for (const MeshMember part : MESH_MEMBERS) {
    Topic& topic = topics_[part];
    topic.subscription.end();
    topic.subscribed = false;
    topic.error.clear();
    topic.resolved.clear();
  }
}

void MeshSources::clear()
{
  disconnect();
  for (const MeshMember part : MESH_MEMBERS) {
    forget(part);
  }
}

}  // namespace rviz_mesh_plugin
