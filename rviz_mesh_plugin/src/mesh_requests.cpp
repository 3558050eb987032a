#include "rviz_mesh_plugin/mesh_requests.h"

#include <algorithm>

#include "rviz_mesh_plugin/cost_properties.h"
#include "rviz_mesh_plugin/mesh_feed.h"
#include "rviz_mesh_plugin/mesh_properties.h"
#include "rviz_mesh_plugin/mesh_store.h"

namespace rviz_mesh_plugin {

bool MeshRequests::due(const std::string& what, bool needed, bool has_topic, Clock::time_point now)
{
  if (!needed) {
    since_.erase(what);
    return false;
  }
  const auto missed = since_.emplace(what, now).first->second;
  return !has_topic || now - missed >= PATIENCE;
}

void MeshRequests::update(Clock::time_point now, MeshFeed& feed, const MeshProperties& properties,
                          const MeshStore& store)
{
  MeshServices& services = feed.services();
  const MeshDataConstPtr mesh = store.newest();
  const bool has_topic = !feed.topic(MeshFeed::GEOMETRY).empty();
  if (due("mesh", !mesh, has_topic, now)) {
    services.requestMesh(std::string());
    mesh_asked_ = true;
  }
  if (!mesh) {
    return;
  }
  if (mesh_asked_) {
    mesh_asked_ = false;
    const MeshServices::Report::State state = services.report().worst();
    if (state != MeshServices::Report::State::ANSWERED) {
      services.cancel();  // a topic has brought the mesh
      since_.clear();
    }
  }
  const MeshAttributes& attributes = store.attributes();
  const DisplayType type = properties.displayType();
  // A display within another one shows what there is to be chosen.
  const bool everything = properties.sourceGiven();
  const std::string suffix = " " + mesh->uuid;
  if (due("colors" + suffix,
          (everything || type == DisplayType::VERTEX_COLOR) && !attributes.colors,
          !feed.topic(MeshFeed::COLORS).empty(), now)) {
    services.requestColors(mesh->uuid);
  }
  if (due("materials" + suffix,
          (everything || type == DisplayType::TEXTURES) && !attributes.materials,
          !feed.topic(MeshFeed::MATERIALS).empty(), now)) {
    services.requestMaterials(mesh->uuid);
  }
  const std::string chosen = properties.costs().costsType();
  const bool layer_missing = chosen.empty() ? attributes.costs.empty() : !attributes.cost(chosen);
  const bool costs = type == DisplayType::VERTEX_COSTS;
  if (due("costs" + suffix, (costs && layer_missing) || (everything && attributes.costs.empty()),
          !feed.topic(MeshFeed::COSTS).empty() || !feed.topic(MeshFeed::FACE_COSTS).empty(), now)) {
    services.requestCosts(mesh->uuid);
    const std::vector<std::string> layers = services.layers(mesh->uuid);
    if (costs && std::find(layers.begin(), layers.end(), chosen) != layers.end()) {
      services.requestLayer(mesh->uuid, chosen);
    }
  }
  if (due("labels" + suffix, properties.labelsShown(), false, now)) {
    services.requestLabels(mesh->uuid);
  }
}

}  // namespace rviz_mesh_plugin
