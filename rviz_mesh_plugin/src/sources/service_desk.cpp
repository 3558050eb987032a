#include "sources/service_desk.h"

#include <exception>
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

#include "ros_client/message_lengths.h"
#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

// What has no property of its own.
const char* const GEOMETRY = "get_geometry";
const char* const LAYERS = "get_vertex_cost_layers";
const char* const COSTS = "get_vertex_costs";
const char* const LABELS = "get_labeled_clusters";

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

template <class Service>
ServiceType serviceType()
{
  namespace traits = ros::service_traits;
  return {traits::datatype<Service>(), traits::md5sum<Service>()};
}

}  // namespace

/// Questions to services of a map by their types, which may not be there yet, and what there is to
/// be said about the answers: the log says how it goes.
class ServiceDesk::ServiceDialog
{
 public:
  /// All have to outlive this.
  ServiceDialog(const ServiceNames& names, const Cancellation& cancellation, ServiceLog& log)
      : names_(names), cancellation_(cancellation), log_(log)
  {
  }

  /// Waits for an answer. @throw Cancelled
  /// @param name that of the service that has answered
  /// @return whether there is a response; if not, the log says why
  template <class Service>
  bool get(const std::string& service, const typename Service::Request& request,
           typename Service::Response& response, std::string& name);

  enum class Outcome
  {
    ANSWERED,
    REFUSED,
    NOT_YET
  };
  struct Result
  {
    Outcome outcome = Outcome::NOT_YET;
    std::string name;  ///< of the service that answered or refused
    ServiceAnswer answer;
  };

  /// Tries each of the names once; says in the log how that goes, but for the end. @throw Cancelled
  Result tryOnce(const std::string& service, const std::vector<std::string>& names,
                 const std::vector<ServiceType>& types, const ros::SerializedMessage& request);

  /// A second. @throw Cancelled
  void pause() const { cancellation_.wait(-1, 0, 1000); }

  /// @return whether there is a response; if not, the log says why
  template <class Response>
  bool read(const std::string& service, const Result& result, Response& response);

  /// @throw ros::InvalidNameException
  std::vector<std::string> candidates(const std::string& service) const
  {
    return serviceCandidates(service, names_);
  }

  /// Whether an answer is about the mesh that was asked for.
  /// @param given by the answer; where it names none, the one asked for
  bool belongs(const std::string& service, const std::string& name, const std::string& asked,
               std::string& given);

  /// What became of an answer.
  /// @param remark more about one that was accepted
  /// @return @a accepted
  bool finish(const std::string& service, const std::string& name, bool accepted,
              const std::string& remark = std::string());

 private:
  /// Once a second, until there is an answer or a refusal. @throw Cancelled
  Result ask(const std::string& service, const std::vector<std::string>& names,
             const std::vector<ServiceType>& types, const ros::SerializedMessage& request);
  bool findNames(const std::string& service, std::vector<std::string>& names);

  const ServiceNames& names_;
  const Cancellation& cancellation_;
  ServiceLog& log_;
};

ServiceDesk::ServiceDialog::Result ServiceDesk::ServiceDialog::tryOnce(
    const std::string& service, const std::vector<std::string>& names,
    const std::vector<ServiceType>& types, const ros::SerializedMessage& request)
{
  Result refused;
  std::string lost, objector, objection;
  const auto refuse = [&](const std::string& name, const std::string& reason) {
    if (refused.outcome == Outcome::NOT_YET) {
      refused.outcome = Outcome::REFUSED;
      refused.name = name;
      refused.answer.refusal = reason;
    }
  };
  for (const std::string& name : names) {
    try {
      const auto address = lookUpService(name, cancellation_);
      if (!address) {
        continue;
      }
      log_.ask(service, name);
      Result result;
      result.name = name;
      result.answer =
          callService(name, *address, types, request, cancellation_,
                      [&](std::size_t bytes, std::size_t of) { log_.receive(service, bytes, of); });
      if (result.answer.refusal.empty()) {
        result.outcome = Outcome::ANSWERED;
        return result;
      }
      refuse(name, result.answer.refusal);
    } catch (const Cancelled&) {
      throw;
    } catch (const ConnectionLost& error) {
      lost = name + " does not answer: " + error.what();
    } catch (const WrongService& error) {
      objector = name;
      objection = error.what();
    } catch (const std::exception& error) {  // out of memory, or of files
      refuse(name, std::string("its answer cannot be read: ") + error.what());
    }
  }
  if (refused.outcome == Outcome::NOT_YET) {
    if (objection.empty()) {
      log_.search(service, names, lost);
    } else {
      log_.object(service, objector, objection);
    }
  }
  return refused;
}

ServiceDesk::ServiceDialog::Result ServiceDesk::ServiceDialog::ask(
    const std::string& service, const std::vector<std::string>& names,
    const std::vector<ServiceType>& types, const ros::SerializedMessage& request)
{
  while (true) {
    Result result = tryOnce(service, names, types, request);
    if (result.outcome != Outcome::NOT_YET) {
      return result;
    }
    pause();
  }
}

template <class Response>
bool ServiceDesk::ServiceDialog::read(const std::string& service, const Result& result,
                                      Response& response)
{
  if (result.outcome == Outcome::REFUSED) {
    log_.fail(service, result.name, "refuses: " + result.answer.refusal);
    return false;
  }
  try {
    const ros::SerializedMessage& bytes = result.answer.response;
    const std::string reason = findFalseLength<Response>(bytes.message_start, bytes.num_bytes);
    if (!reason.empty()) {
      throw std::length_error(reason);
    }
    ros::serialization::deserializeMessage(bytes, response);
    return true;
  } catch (const std::exception& error) {
    log_.fail(service, result.name,
              std::string("gives an answer that cannot be read: ") + error.what());
  }
  return false;
}

template <class Service>
bool ServiceDesk::ServiceDialog::get(const std::string& service,
                                     const typename Service::Request& request,
                                     typename Service::Response& response, std::string& name)
{
  std::vector<std::string> names;
  if (!findNames(service, names)) {
    return false;
  }
  const auto result =
      ask(service, names, {serviceType<Service>()}, ros::serialization::serializeMessage(request));
  name = result.name;
  return read(service, result, response);
}

bool ServiceDesk::ServiceDialog::findNames(const std::string& service,
                                           std::vector<std::string>& names)
{
  try {
    names = candidates(service);
    return true;
  } catch (const ros::InvalidNameException& error) {
    log_.fail(service, "'" + service + "'",
              std::string("is no name of a service: ") + error.what());
  }
  return false;
}

bool ServiceDesk::ServiceDialog::belongs(const std::string& service, const std::string& name,
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

bool ServiceDesk::ServiceDialog::finish(const std::string& service, const std::string& name,
                                        bool accepted, const std::string& remark)
{
  if (accepted) {
    log_.answer(service, name, remark);
  } else {
    log_.fail(service, name, "answers with what cannot be shown, as the line on it says");
  }
  return accepted;
}

ServiceDesk::ServiceDesk(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader,
                         ServiceNames names)
    : inbox_(std::move(inbox)),
      loader_(std::move(loader)),
      names_(std::move(names)),
      dialog_(std::make_unique<ServiceDialog>(names_, cancellation_, log_))
{
}

ServiceDesk::~ServiceDesk() = default;

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

bool ServiceDesk::missesTextures(const std::string& uuid) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return missing_textures_.count(uuid) != 0;
}

bool ServiceDesk::fetchMesh(std::string uuid, bool again)
{
  log_.want(GEOMETRY, {}, again);
  if (uuid.empty()) {
    const bool brought = findMesh(uuid);
    if (brought || uuid.empty()) {
      return brought;
    }
  }
  mesh_msgs::GetGeometry::Request request;
  request.uuid = uuid;
  mesh_msgs::GetGeometry::Response response;
  std::string name;
  return dialog_->get<mesh_msgs::GetGeometry>(GEOMETRY, request, response, name) &&
         deliverMesh(name, uuid,
                     boost::make_shared<mesh_msgs::MeshGeometryStamped>(
                         std::move(response.mesh_geometry_stamped)));
}

bool ServiceDesk::findMesh(std::string& uuid)
{
  const std::vector<ServiceType> types = {serviceType<mesh_msgs::GetUUIDs>(),
                                          serviceType<mesh_msgs::GetUUID>()};
  const auto request = ros::serialization::serializeMessage(mesh_msgs::GetUUIDsRequest());
  std::vector<std::string> names;
  const auto listed = dialog_->candidates("get_uuids");
  const auto single = dialog_->candidates("get_uuid");
  for (std::size_t i = 0; i < listed.size(); ++i) {  // of each namespace both
    names.push_back(listed[i]);
    if (i < single.size()) {
      names.push_back(single[i]);
    }
  }
  while (true) {
    const auto result = dialog_->tryOnce(GEOMETRY, names, types, request);
    if (result.outcome == ServiceDialog::Outcome::ANSWERED) {
      mesh_msgs::GetUUIDs::Response all;
      mesh_msgs::GetUUID::Response one;
      if (!(result.answer.type == 0 ? dialog_->read(GEOMETRY, result, all)
                                    : dialog_->read(GEOMETRY, result, one))) {
        return false;
      }
      uuid = result.answer.type == 1 ? one.uuid : all.uuids.empty() ? "" : all.uuids.front();
      if (!uuid.empty()) {
        return false;
      }
      log_.search(GEOMETRY, {}, result.name + " names no mesh yet");
    } else {
      mesh_msgs::GetGeometry::Response response;
      const auto geometry = dialog_->tryOnce(
          GEOMETRY, dialog_->candidates(GEOMETRY), {serviceType<mesh_msgs::GetGeometry>()},
          ros::serialization::serializeMessage(mesh_msgs::GetGeometry::Request()));
      if (geometry.outcome != ServiceDialog::Outcome::NOT_YET) {
        return dialog_->read(GEOMETRY, geometry, response) &&
               deliverMesh(geometry.name, uuid,
                           boost::make_shared<mesh_msgs::MeshGeometryStamped>(
                               std::move(response.mesh_geometry_stamped)));
      }
    }
    dialog_->pause();
  }
}

bool ServiceDesk::deliverMesh(const std::string& name, const std::string& asked,
                              const mesh_msgs::MeshGeometryStamped::Ptr& mesh)
{
  if (!dialog_->belongs(GEOMETRY, name, asked, mesh->uuid)) {
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

bool ServiceDesk::fetchColors(const std::string& uuid, bool again)
{
  log_.want(names_.colors, {}, again);
  mesh_msgs::GetVertexColors::Request request;
  request.uuid = uuid;
  mesh_msgs::GetVertexColors::Response response;
  std::string name;
  auto& colors = response.mesh_vertex_colors_stamped;
  if (!dialog_->get<mesh_msgs::GetVertexColors>(names_.colors, request, response, name)) {
    return false;
  }
  // Servers answer so, with or without the uuid, for a mesh that has none.
  if (colors.mesh_vertex_colors.vertex_colors.empty()) {
    log_.answer(names_.colors, name, "the mesh has no vertex colors");
    return false;
  }
  return dialog_->belongs(names_.colors, name, uuid, colors.uuid) &&
         dialog_->finish(names_.colors, name, inbox_->receive(colors, &cancellation_.flag()));
}

bool ServiceDesk::fetchMaterials(const std::string& uuid, bool again)
{
  std::set<std::uint32_t> textures;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (const auto missing = missing_textures_.find(uuid); missing != missing_textures_.end()) {
      textures = missing->second;
    }
  }
  if (!textures.empty()) {
    return fetchTextures(uuid, textures, true);
  }
  log_.want(names_.materials, {}, again);
  mesh_msgs::GetMaterials::Request request;
  request.uuid = uuid;
  mesh_msgs::GetMaterials::Response response;
  std::string name;
  auto& materials = response.mesh_materials_stamped;
  if (!dialog_->get<mesh_msgs::GetMaterials>(names_.materials, request, response, name)) {
    return false;
  }
  if (materials.mesh_materials.materials.empty()) {
    log_.answer(names_.materials, name, "the mesh has no materials");
    return false;
  }
  if (!dialog_->belongs(names_.materials, name, uuid, materials.uuid) ||
      !dialog_->finish(names_.materials, name, inbox_->receive(materials, &cancellation_.flag()))) {
    return false;
  }
  if (names_.texture.empty()) {
    return true;
  }
  textures = texturesOf(materials.mesh_materials);
  response = mesh_msgs::GetMaterials::Response();
  return fetchTextures(uuid, textures, false);
}

bool ServiceDesk::fetchTextures(const std::string& uuid, const std::set<std::uint32_t>& indices,
                                bool again)
{
  for (std::size_t i = 0; i < indices.size(); ++i) {
    log_.want(names_.texture, "textures", again);
  }
  std::set<std::uint32_t> missing;
  for (const std::uint32_t index : indices) {
    if (!fetchTexture(uuid, index)) {
      missing.insert(index);
    }
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (missing.empty()) {
    missing_textures_.erase(uuid);
    return true;
  }
  missing_textures_[uuid] = std::move(missing);
  return false;
}

bool ServiceDesk::fetchTexture(const std::string& uuid, std::uint32_t index)
{
  mesh_msgs::GetTexture::Request request;
  request.uuid = uuid;
  request.texture_index = index;
  mesh_msgs::GetTexture::Response response;
  std::string name;
  auto& texture = response.texture;
  if (!dialog_->get<mesh_msgs::GetTexture>(names_.texture, request, response, name) ||
      !dialog_->belongs(names_.texture, name, uuid, texture.uuid)) {
    return false;
  }
  if (texture.texture_index != index) {
    log_.fail(names_.texture, name,
              "answers with texture " + std::to_string(texture.texture_index) + " instead of " +
                  std::to_string(index));
    return false;
  }
  return dialog_->finish(names_.texture, name, inbox_->receive(texture, &cancellation_.flag()));
}

/// Never all: further layers may be computed.
bool ServiceDesk::fetchLayerNames(const std::string& uuid, bool again)
{
  log_.want(LAYERS, {}, again);
  mesh_msgs::GetVertexCostLayers::Request request;
  request.uuid = uuid;
  mesh_msgs::GetVertexCostLayers::Response response;
  std::string name;
  if (dialog_->get<mesh_msgs::GetVertexCostLayers>(LAYERS, request, response, name)) {
    log_.answer(LAYERS, name, std::to_string(response.layers.size()) + " cost layers");
    const std::lock_guard<std::mutex> lock(mutex_);
    layers_[uuid] = std::move(response.layers);
  }
  return false;
}

bool ServiceDesk::fetchLayer(const std::string& uuid, const std::string& type, bool again)
{
  log_.want(COSTS, "layers", again);
  mesh_msgs::GetVertexCosts::Request request;
  request.uuid = uuid;
  request.layer = type;
  mesh_msgs::GetVertexCosts::Response response;
  std::string name;
  auto& costs = response.mesh_vertex_costs_stamped;
  if (!dialog_->get<mesh_msgs::GetVertexCosts>(COSTS, request, response, name) ||
      !dialog_->belongs(COSTS, name, uuid, costs.uuid)) {
    return false;
  }
  costs.type = costs.type.empty() ? type : costs.type;
  return dialog_->finish(COSTS, name, inbox_->receive(costs, &cancellation_.flag()));
}

bool ServiceDesk::fetchLabels(const std::string& uuid, bool again)
{
  log_.want(LABELS, {}, again);
  mesh_msgs::GetLabeledClusters::Request request;
  request.uuid = uuid;
  mesh_msgs::GetLabeledClusters::Response response;
  std::string name;
  if (!dialog_->get<mesh_msgs::GetLabeledClusters>(LABELS, request, response, name)) {
    return false;
  }
  return dialog_->finish(
      LABELS, name, inbox_->receiveLabels(uuid, response.clusters, true, &cancellation_.flag()),
      std::to_string(response.clusters.size()) + " labels");
}

}  // namespace rviz_mesh_plugin
