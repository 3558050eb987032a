#include "displays/mesh_requests.h"

#include <algorithm>
#include <utility>

#include "incoming/mesh_store.h"
#include "properties/cost_properties.h"
#include "properties/mesh_properties.h"
#include "sources/mesh_sources.h"

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

void MeshRequests::update(Clock::time_point now)
{
  MapServiceClient& services = sources_.services();
  const MeshDataConstPtr mesh = store_.newest();
  forgetGone();
  const bool has_topic = !sources_.topic(MeshMember::GEOMETRY).empty();
  // Within another display that shows nothing, a server that happens to be there is not meant.
  const bool wanted = has_topic || !properties_.sourceGiven();
  if (due("mesh", !mesh && wanted, has_topic, now)) {
    services.requestMesh(std::string());
    mesh_asked_ = true;
  }
  if (!mesh) {
    return;
  }
  if (mesh_asked_) {
    mesh_asked_ = false;
    const ServiceReport::State state = services.report().worst;
    if (state != ServiceReport::State::ANSWERED) {
      services.cancel();  // a topic has brought the mesh
      since_.clear();
    }
  }
  for (const MeshDataConstPtr& shown : store_.meshes()) {
    requestAttributes(now, shown->uuid);
  }
}

void MeshRequests::forgetGone()
{
  std::set<std::string> uuids;
  for (const MeshDataConstPtr& mesh : store_.meshes()) {
    uuids.insert(mesh->uuid);
  }
  // Else a publisher of ever new uuids would leave a request behind for each of them.
  if (!std::includes(uuids.begin(), uuids.end(), uuids_.begin(), uuids_.end())) {
    sources_.services().cancel();
    since_.clear();
  }
  uuids_ = std::move(uuids);
}

void MeshRequests::requestAttributes(Clock::time_point now, const std::string& uuid)
{
  MapServiceClient& services = sources_.services();
  const MeshAttributes& attributes = store_.attributes(uuid);
  const DisplayType type = properties_.displayType();
  // A display within another one shows what there is to be chosen.
  const bool everything = properties_.sourceGiven() || properties_.isAutomatic();
  const std::string suffix = " " + uuid;
  if (due("colors" + suffix,
          (everything || type == DisplayType::VERTEX_COLOR) && !attributes.colors,
          !sources_.topic(MeshMember::COLORS).empty(), now)) {
    services.requestColors(uuid);
  }
  if (due("materials" + suffix,
          (everything || type == DisplayType::TEXTURES) &&
              (!attributes.materials || services.missesTextures(uuid)),
          !sources_.topic(MeshMember::MATERIALS).empty(), now)) {
    services.requestMaterials(uuid);
  }
  const std::string chosen = properties_.costs().costsType();
  const bool layer_missing = chosen.empty() ? attributes.costs.empty() : !attributes.cost(chosen);
  const bool costs = type == DisplayType::VERTEX_COSTS;
  if (due("costs" + suffix, (costs && layer_missing) || (everything && attributes.costs.empty()),
          !sources_.topic(MeshMember::COSTS).empty() ||
              !sources_.topic(MeshMember::FACE_COSTS).empty(),
          now)) {
    services.requestCosts(uuid);
    const std::vector<std::string> layers = services.layers(uuid);
    if (costs && std::find(layers.begin(), layers.end(), chosen) != layers.end()) {
      services.requestLayer(uuid, chosen);
    }
  }
  if (due("labels" + suffix, properties_.labelsShown(), false, now)) {
    services.requestLabels(uuid);
  }
}

}  // namespace rviz_mesh_plugin
