#include "rviz_mesh_plugin/mesh_feed.h"

#include "rviz_mesh_plugin/cost_properties.h"
#include "rviz_mesh_plugin/mesh_properties.h"
#include "rviz_mesh_plugin/mesh_store.h"

namespace rviz_mesh_plugin {
namespace {

using Subscribe = std::string (MeshTopics::*)(ros::NodeHandle&, const std::string&);

/// In the order of MeshFeed::Kind.
constexpr Subscribe SUBSCRIBE[MeshFeed::KINDS] = {
    &MeshTopics::subscribeGeometry, &MeshTopics::subscribeCosts,  &MeshTopics::subscribeFaceCosts,
    &MeshTopics::subscribeUpdates,  &MeshTopics::subscribeColors, &MeshTopics::subscribeMaterials,
    &MeshTopics::subscribeTextures, &MeshTopics::subscribeLabels};

}  // namespace

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
  services_->setNames(properties.services());
  const MeshSource source = properties.source();
  const std::array<std::string, KINDS> names{
      source.geometry_topic,      source.costs_topic,  source.face_costs_topic,
      properties.updatesTopic(),  source.colors_topic, properties.materialsTopic(),
      properties.texturesTopic(), source.labels_topic};
  bool forgotten = false;
  for (int kind = 0; kind < KINDS; ++kind) {
    Topic& topic = topics_[kind];
    const bool renamed = topic.name != names[kind];
    if (renamed) {
      (subscriptions_.*SUBSCRIBE[kind])(node_handle, std::string());
      topic.subscribed = false;
      forget(static_cast<Kind>(kind), store);
      forgotten = true;
    }
    if (!topic.subscribed) {
      topic.name = names[kind];
      topic.error = (subscriptions_.*SUBSCRIBE[kind])(node_handle, topic.name);
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
    case FACE_COSTS:
    case UPDATES:
      inbox_->clearCosts();
      inbox_->clearFaceCosts();
      inbox_->clearUpdates();
      store.clearCosts();
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
