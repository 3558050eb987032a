#include "mesh_view/mesh_feed.h"

#include <ros/message_traits.h>

#include "incoming/mesh_store.h"
#include "properties/mesh_properties.h"

namespace rviz_mesh_plugin {
namespace {

using Subscribe = std::string (MeshTopics::*)(ros::NodeHandle&, const std::string&);

/// In the order of MeshFeed::Kind.
constexpr Subscribe SUBSCRIBE[MeshFeed::KINDS] = {
    &MeshTopics::subscribeGeometry, &MeshTopics::subscribeCosts,  &MeshTopics::subscribeFaceCosts,
    &MeshTopics::subscribeUpdates,  &MeshTopics::subscribeColors, &MeshTopics::subscribeMaterials,
    &MeshTopics::subscribeTextures, &MeshTopics::subscribeLabels};

}  // namespace

const char* MeshFeed::type(Kind kind)
{
  using ros::message_traits::datatype;
  static const char* const TYPES[KINDS] = {datatype<mesh_msgs::MeshGeometryStamped>(),
                                           datatype<mesh_msgs::MeshVertexCostsStamped>(),
                                           datatype<mesh_msgs::MeshFaceCostsStamped>(),
                                           datatype<mesh_msgs::MeshVertexCostsSparseStamped>(),
                                           datatype<mesh_msgs::MeshVertexColorsStamped>(),
                                           datatype<mesh_msgs::MeshMaterialsStamped>(),
                                           datatype<mesh_msgs::MeshTexture>(),
                                           datatype<mesh_msgs::MeshFaceCluster>()};
  return TYPES[kind];
}

MeshFeed::MeshFeed()
    : inbox_(std::make_shared<MeshInbox>()),
      loader_(std::make_shared<MeshLoader>()),
      services_(std::make_unique<MeshServices>(inbox_, loader_)),
      subscriptions_(inbox_, loader_)
{
}

MeshFeed::~MeshFeed()
{
  subscriptions_.unsubscribe();
}

bool MeshFeed::connect(ros::NodeHandle& node_handle, const MeshProperties& properties,
                       MeshStore& store)
{
  const ServiceNames service_names = properties.services();
  services_->setNames(service_names);
  const MeshSource source = properties.source();
  const std::array<std::string, KINDS> names{
      source.geometry_topic, source.costs_topic,     source.face_costs_topic, source.updates_topic,
      source.colors_topic,   source.materials_topic, source.textures_topic,   source.labels_topic};
  std::array<std::string, KINDS> services;
  services[COLORS] = service_names.colors;
  services[MATERIALS] = service_names.materials;
  services[TEXTURES] = service_names.texture;
  std::array<bool, KINDS> renamed{};
  for (int kind = 0; kind < KINDS; ++kind) {
    renamed[kind] = topics_[kind].name != names[kind] || topics_[kind].service != services[kind];
  }
  // Textures are asked for with their materials.
  renamed[MATERIALS] = renamed[TEXTURES] = renamed[MATERIALS] || renamed[TEXTURES];
  bool forgotten = false;
  for (int kind = 0; kind < KINDS; ++kind) {
    Topic& topic = topics_[kind];
    if (renamed[kind]) {
      (subscriptions_.*SUBSCRIBE[kind])(node_handle, std::string());
      topic.subscribed = false;
      forget(static_cast<Kind>(kind), store);
      forgotten = true;
    }
    if (!topic.subscribed) {
      topic.name = names[kind];
      topic.service = services[kind];
      topic.error = (subscriptions_.*SUBSCRIBE[kind])(node_handle, topic.name);
      topic.resolved = topic.name.empty() || !topic.error.empty()
                           ? std::string()
                           : node_handle.resolveName(topic.name);
      topic.subscribed = true;
    }
  }
  if (forgotten) {
    services_->cancel();  // what they brought may be among it
  }
  return forgotten;
}

void MeshFeed::forget(Kind kind, MeshStore& store)
{
  switch (kind) {
    case GEOMETRY:
      loader_->clear();
      store.clearMeshes();
      break;
    case COSTS:
      inbox_->clearCosts();
      store.clearCosts(false);
      break;
    case FACE_COSTS:
      inbox_->clearFaceCosts();
      store.clearCosts(true);
      break;
    case UPDATES:
      inbox_->clearUpdates();
      store.clearUpdates();
      break;
    case COLORS:
      inbox_->clearColors();
      store.clearColors();
      break;
    case MATERIALS:
    case TEXTURES:
      inbox_->clearMaterials();
      store.clearMaterials();
      break;
    default:
      inbox_->clearLabels();
      store.clearLabels();
  }
}

void MeshFeed::disconnect()
{
  subscriptions_.unsubscribe();
  services_->cancel();
  for (Topic& topic : topics_) {
    topic.subscribed = false;
    topic.error.clear();
    topic.resolved.clear();
  }
}

void MeshFeed::clear()
{
  disconnect();
  loader_->clear();
  inbox_->clearCosts();
  inbox_->clearFaceCosts();
  inbox_->clearUpdates();
  inbox_->clearColors();
  inbox_->clearMaterials();
  inbox_->clearLabels();
}

}  // namespace rviz_mesh_plugin
