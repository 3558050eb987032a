#include "sources/mesh_feed.h"

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
struct MeshFeed::Channel
{
  const char* type;
  void (MeshFeed::*subscribe)(ros::NodeHandle& node_handle, MeshNews part);
};

template <class Message, std::uint32_t queue>
void MeshFeed::subscribe(ros::NodeHandle& node_handle, MeshNews part)
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
    callbacks.receive = [inbox = inbox_](const auto& message, const Flag& ended) {
      inbox->receive(*message, &ended);
    };
    callbacks.refuse = [inbox = inbox_, part](const std::string& reason, const Flag& ended) {
      inbox->refuse(part, reason, &ended);
    };
  }
  Topic& topic = topics_[part];
  topic.subscription = receiver_.subscribe(node_handle, topic.name, queue, callbacks);
}

const MeshFeed::Channel& MeshFeed::channel(MeshNews part)
{
  using namespace mesh_msgs;
  using ros::message_traits::datatype;
  static const PerNews<Channel> channels = [] {
    PerNews<Channel> all;
    all[MeshNews::GEOMETRY] = {datatype<MeshGeometryStamped>(),
                               &MeshFeed::subscribe<MeshGeometryStamped, GEOMETRY_QUEUE>};
    all[MeshNews::COSTS] = {datatype<MeshVertexCostsStamped>(),
                            &MeshFeed::subscribe<MeshVertexCostsStamped, BURST_QUEUE>};
    all[MeshNews::FACE_COSTS] = {datatype<MeshFaceCostsStamped>(),
                                 &MeshFeed::subscribe<MeshFaceCostsStamped, BURST_QUEUE>};
    all[MeshNews::UPDATES] = {datatype<MeshVertexCostsSparseStamped>(),
                              &MeshFeed::subscribe<MeshVertexCostsSparseStamped, BURST_QUEUE>};
    all[MeshNews::COLORS] = {datatype<MeshVertexColorsStamped>(),
                             &MeshFeed::subscribe<MeshVertexColorsStamped, FEW_QUEUE>};
    all[MeshNews::MATERIALS] = {datatype<MeshMaterialsStamped>(),
                                &MeshFeed::subscribe<MeshMaterialsStamped, FEW_QUEUE>};
    all[MeshNews::TEXTURES] = {datatype<MeshTexture>(),
                               &MeshFeed::subscribe<MeshTexture, BURST_QUEUE>};
    // Each message is one label as it is now.
    all[MeshNews::LABELS] = {datatype<MeshFaceCluster>(),
                             &MeshFeed::subscribe<MeshFaceCluster, LABELS_QUEUE>};
    return all;
  }();
  return channels[part];
}

const char* MeshFeed::type(MeshNews part)
{
  return channel(part).type;
}

MeshFeed::MeshFeed(bool with_layouts)
    : inbox_(std::make_shared<MeshInbox>()),
      loader_(std::make_shared<MeshLoader>(with_layouts)),
      services_(inbox_, loader_)
{
}

MeshFeed::~MeshFeed() = default;

std::vector<MeshNews> MeshFeed::connect(ros::NodeHandle& node_handle, const Names& names)
{
  services_.setNames(names.services);
  PerNews<std::string> services;
  services[MeshNews::COLORS] = names.services.colors;
  services[MeshNews::MATERIALS] = names.services.materials;
  services[MeshNews::TEXTURES] = names.services.texture;
  PerNews<bool> renamed;
  for (const MeshNews part : MESH_NEWS) {
    renamed[part] =
        topics_[part].name != names.topics[part] || topics_[part].service != services[part];
  }
  // Textures are asked for with their materials.
  renamed[MeshNews::MATERIALS] = renamed[MeshNews::TEXTURES] =
      renamed[MeshNews::MATERIALS] || renamed[MeshNews::TEXTURES];
  std::vector<MeshNews> forgotten;
  for (const MeshNews part : MESH_NEWS) {
    Topic& topic = topics_[part];
    if (renamed[part]) {
      topic.subscription.end();
      topic.subscribed = false;
      forget(part);
      forgotten.push_back(part);
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
  if (!forgotten.empty()) {
    services_.cancel();  // what they brought may be among it
  }
  return forgotten;
}

void MeshFeed::forget(MeshNews part)
{
  if (part == MeshNews::GEOMETRY) {
    loader_->clear();
  }
  inbox_->forget(part);
}

void MeshFeed::disconnect()
{
  services_.cancel();
  for (const MeshNews part : MESH_NEWS) {
    Topic& topic = topics_[part];
    topic.subscription.end();
    topic.subscribed = false;
    topic.error.clear();
    topic.resolved.clear();
  }
}

void MeshFeed::clear()
{
  disconnect();
  for (const MeshNews part : MESH_NEWS) {
    forget(part);
  }
}

}  // namespace rviz_mesh_plugin
