#include "rviz_mesh_plugin/service_desk.h"

#include <set>
#include <stdexcept>
#include <utility>

#include <mesh_msgs/GetGeometry.h>
#include <mesh_msgs/GetLabeledClusters.h>
#include <mesh_msgs/GetMaterials.h>
#include <mesh_msgs/GetTexture.h>
#include <mesh_msgs/GetUUID.h>
#include <mesh_msgs/GetUUIDs.h>
#include <mesh_msgs/GetVertexColors.h>
#include <mesh_msgs/GetVertexCostLayers.h>
#include <mesh_msgs/GetVertexCosts.h>
#include <ros/exceptions.h>
#include <ros/serialization.h>
#include <ros/service_traits.h>
#include <boost/make_shared.hpp>

namespace rviz_mesh_plugin {
namespace {

using Outcome = ServiceAsker::Outcome;

// What has no property of its own.
const char* const GEOMETRY = "get_geometry";
const char* const LAYERS = "get_vertex_cost_layers";
const char* const COSTS = "get_vertex_costs";
const char* const LABELS = "get_labeled_clusters";

template <class Service>
ServiceType typeOf()
{
  namespace traits = ros::service_traits;
  return {traits::datatype<Service>(), traits::md5sum<Service>()};
}

/// The textures that the materials refer to.
std::set<std::uint32_t> texturesOf(const mesh_msgs::MeshMaterials& materials)
{
  std::set<std::uint32_t> indices;
  if (!materials.vertex_tex_coords.empty()) {
    for (const auto& material : materials.materials) {
      if (material.has_texture && material.texture_index != NONE) {
        indices.insert(material.texture_index);
      }
    }
  }
  return indices;
}

}  // namespace

ServiceDesk::ServiceDesk(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader,
                         ServiceNames names)
    : inbox_(std::move(inbox)),
      loader_(std::move(loader)),
      names_(std::move(names)),
      asker_(cancellation_, log_)
{
}

void ServiceDesk::cancel()
{
  const std::lock_guard<std::mutex> lock(mutex_);  // waits for a mesh that is being handed over
  cancellation_.set();
}

std::vector<std::string> ServiceDesk::layers(const std::string& uuid) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = layers_.find(uuid);
  return found == layers_.end() ? std::vector<std::string>() : found->second;
}

std::vector<std::string> ServiceDesk::candidates(const std::string& service) const
{
  return serviceCandidates(service, names_);
}

template <class Response>
bool ServiceDesk::read(const std::string& service, const ServiceAsker::Result& result,
                       Response& response)
{
  if (result.outcome == Outcome::REFUSED) {
    log_.fail(service, result.name, "refuses: " + result.answer.refusal);
    return false;
  }
  try {
    ros::serialization::deserializeMessage(result.answer.response, response);
    return true;
  } catch (const std::exception& error) {
    log_.fail(service, result.name,
              std::string("gives an answer that cannot be read: ") + error.what());
  }
  return false;
}

template <class Service>
bool ServiceDesk::get(const std::string& service, const typename Service::Request& request,
                      typename Service::Response& response, std::string& name)
{
  std::vector<std::string> names;
  try {
    names = candidates(service);
  } catch (const ros::InvalidNameException& error) {
    log_.fail(service, "'" + service + "'",
              std::string("is no name of a service: ") + error.what());
    return false;
  }
  const auto result = asker_.ask(service, names, {typeOf<Service>()},
                                 ros::serialization::serializeMessage(request));
  name = result.name;
  return read(service, result, response);
}

bool ServiceDesk::belongs(const std::string& service, const std::string& name,
                          const std::string& asked, std::string& given)
{
  if (given.empty()) {
    given = asked;
  }
  // "" and "mesh" mean the only one.
  if (asked.empty() || asked == "mesh" || given == asked) {
    return true;
  }
  log_.fail(
      service, name,
      "answers for the mesh '" + given + "', but '" + asked + "' is shown; it serves another map");
  return false;
}

void ServiceDesk::finish(const std::string& service, const std::string& name, bool accepted)
{
  if (accepted) {
    log_.answer(service, name);
  } else {
    log_.fail(service, name, "answers with what cannot be shown, as the line on it says");
  }
}

void ServiceDesk::fetchMesh(std::string uuid)
{
  log_.want(GEOMETRY);
  if (uuid.empty() && !findMesh(uuid)) {
    return;
  }
  mesh_msgs::GetGeometry::Request request;
  request.uuid = uuid;
  mesh_msgs::GetGeometry::Response response;
  std::string name;
  if (get<mesh_msgs::GetGeometry>(GEOMETRY, request, response, name)) {
    deliverMesh(name, uuid,
                boost::make_shared<mesh_msgs::MeshGeometryStamped>(
                    std::move(response.mesh_geometry_stamped)));
  }
}

bool ServiceDesk::findMesh(std::string& uuid)
{
  const std::vector<ServiceType> types = {typeOf<mesh_msgs::GetUUIDs>(),
                                          typeOf<mesh_msgs::GetUUID>()};
  const auto request = ros::serialization::serializeMessage(mesh_msgs::GetUUIDsRequest());
  std::vector<std::string> names;
  const auto listed = candidates("get_uuids");
  const auto single = candidates("get_uuid");
  for (std::size_t i = 0; i < listed.size(); ++i) {  // of each namespace both
    names.push_back(listed[i]);
    if (i < single.size()) {
      names.push_back(single[i]);
    }
  }
  while (true) {
    const auto result = asker_.tryOnce(GEOMETRY, names, types, request);
    if (result.outcome == Outcome::ANSWERED) {
      mesh_msgs::GetUUIDs::Response all;
      mesh_msgs::GetUUID::Response one;
      if (!(result.answer.type == 0 ? read(GEOMETRY, result, all) : read(GEOMETRY, result, one))) {
        return false;
      }
      uuid = result.answer.type == 1 ? one.uuid : all.uuids.empty() ? "" : all.uuids.front();
      if (!uuid.empty()) {
        return true;
      }
      log_.search(GEOMETRY, {}, result.name + " names no mesh yet");
    } else {
      mesh_msgs::GetGeometry::Response response;
      const auto geometry =
          asker_.tryOnce(GEOMETRY, candidates(GEOMETRY), {typeOf<mesh_msgs::GetGeometry>()},
                         ros::serialization::serializeMessage(mesh_msgs::GetGeometry::Request()));
      if (geometry.outcome != Outcome::NOT_YET) {
        if (read(GEOMETRY, geometry, response)) {
          deliverMesh(geometry.name, uuid,
                      boost::make_shared<mesh_msgs::MeshGeometryStamped>(
                          std::move(response.mesh_geometry_stamped)));
        }
        return false;
      }
    }
    asker_.pause();
  }
}

bool ServiceDesk::deliverMesh(const std::string& name, const std::string& asked,
                              const mesh_msgs::MeshGeometryStamped::Ptr& mesh)
{
  if (!belongs(GEOMETRY, name, asked, mesh->uuid)) {
    return false;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (cancellation_.flag() || !loader_) {
    return false;
  }
  loader_->receive(mesh);
  log_.answer(GEOMETRY, name);
  return true;
}

void ServiceDesk::fetchColors(const std::string& uuid)
{
  log_.want(names_.colors);
  mesh_msgs::GetVertexColors::Request request;
  request.uuid = uuid;
  mesh_msgs::GetVertexColors::Response response;
  std::string name;
  auto& colors = response.mesh_vertex_colors_stamped;
  if (!get<mesh_msgs::GetVertexColors>(names_.colors, request, response, name)) {
    return;
  }
  // Servers answer so, with or without the uuid, for a mesh that has none.
  if (colors.mesh_vertex_colors.vertex_colors.empty()) {
    log_.answer(names_.colors, name, "the mesh has no vertex colors");
  } else if (belongs(names_.colors, name, uuid, colors.uuid)) {
    finish(names_.colors, name, inbox_->receive(colors, &cancellation_.flag()));
  }
}

void ServiceDesk::fetchMaterials(const std::string& uuid)
{
  log_.want(names_.materials);
  mesh_msgs::GetMaterials::Request request;
  request.uuid = uuid;
  mesh_msgs::GetMaterials::Response response;
  std::string name;
  auto& materials = response.mesh_materials_stamped;
  if (!get<mesh_msgs::GetMaterials>(names_.materials, request, response, name)) {
    return;
  }
  if (materials.mesh_materials.materials.empty()) {
    log_.answer(names_.materials, name, "the mesh has no materials");
    return;
  }
  if (!belongs(names_.materials, name, uuid, materials.uuid)) {
    return;
  }
  const bool accepted = inbox_->receive(materials, &cancellation_.flag());
  finish(names_.materials, name, accepted);
  if (!accepted || names_.texture.empty()) {
    return;
  }
  const std::set<std::uint32_t> textures = texturesOf(materials.mesh_materials);
  response = mesh_msgs::GetMaterials::Response();
  for (std::size_t i = 0; i < textures.size(); ++i) {
    log_.want(names_.texture, "textures");
  }
  for (const std::uint32_t index : textures) {
    fetchTexture(uuid, index);
  }
}

void ServiceDesk::fetchTexture(const std::string& uuid, std::uint32_t index)
{
  mesh_msgs::GetTexture::Request request;
  request.uuid = uuid;
  request.texture_index = index;
  mesh_msgs::GetTexture::Response response;
  std::string name;
  auto& texture = response.texture;
  if (!get<mesh_msgs::GetTexture>(names_.texture, request, response, name) ||
      !belongs(names_.texture, name, uuid, texture.uuid)) {
    return;
  }
  if (texture.texture_index != index) {
    log_.fail(names_.texture, name,
              "answers with texture " + std::to_string(texture.texture_index) + " instead of " +
                  std::to_string(index));
    return;
  }
  finish(names_.texture, name, inbox_->receive(texture, &cancellation_.flag()));
}

void ServiceDesk::fetchLayerNames(const std::string& uuid)
{
  log_.want(LAYERS);
  mesh_msgs::GetVertexCostLayers::Request request;
  request.uuid = uuid;
  mesh_msgs::GetVertexCostLayers::Response response;
  std::string name;
  if (get<mesh_msgs::GetVertexCostLayers>(LAYERS, request, response, name)) {
    log_.answer(LAYERS, name, std::to_string(response.layers.size()) + " cost layers");
    const std::lock_guard<std::mutex> lock(mutex_);
    layers_[uuid] = std::move(response.layers);
  }
}

void ServiceDesk::fetchLayer(const std::string& uuid, const std::string& type)
{
  log_.want(COSTS, "layers");
  mesh_msgs::GetVertexCosts::Request request;
  request.uuid = uuid;
  request.layer = type;
  mesh_msgs::GetVertexCosts::Response response;
  std::string name;
  auto& costs = response.mesh_vertex_costs_stamped;
  if (get<mesh_msgs::GetVertexCosts>(COSTS, request, response, name) &&
      belongs(COSTS, name, uuid, costs.uuid)) {
    costs.type = costs.type.empty() ? type : costs.type;
    finish(COSTS, name, inbox_->receive(costs, &cancellation_.flag()));
  }
}

void ServiceDesk::fetchLabels(const std::string& uuid)
{
  log_.want(LABELS);
  mesh_msgs::GetLabeledClusters::Request request;
  request.uuid = uuid;
  mesh_msgs::GetLabeledClusters::Response response;
  std::string name;
  if (get<mesh_msgs::GetLabeledClusters>(LABELS, request, response, name)) {
    const std::string remark = std::to_string(response.clusters.size()) + " labels";
    if (inbox_->receiveLabels(uuid, response.clusters, true, &cancellation_.flag())) {
      log_.answer(LABELS, name, remark);
    } else {
      finish(LABELS, name, false);
    }
  }
}

}  // namespace rviz_mesh_plugin
