#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "rviz_mesh_plugin/cancellation.h"
#include "rviz_mesh_plugin/mesh_inbox.h"
#include "rviz_mesh_plugin/mesh_loader.h"
#include "rviz_mesh_plugin/service_asker.h"
#include "rviz_mesh_plugin/service_log.h"
#include "rviz_mesh_plugin/service_names.h"

namespace rviz_mesh_plugin {

/// Asks the services of a map and hands their answers over; each function waits until that is done.
/// Threads may share a desk, and outlive everything else: it owns what it uses.
///
/// The functions throw Cancelled after cancel(), and nothing else.
class ServiceDesk
{
 public:
  ServiceDesk(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader,
              ServiceNames names);

  void fetchMesh(std::string uuid);
  void fetchColors(const std::string& uuid);
  void fetchMaterials(const std::string& uuid);  ///< and textures
  void fetchLayerNames(const std::string& uuid);
  void fetchLayer(const std::string& uuid, const std::string& type);
  void fetchLabels(const std::string& uuid);

  /// Ends all work; nothing is handed over any more.
  void cancel();

  std::vector<std::string> layers(const std::string& uuid) const;
  ServiceLog& log() { return log_; }

 private:
  template <class Service>
  bool get(const std::string& service, const typename Service::Request& request,
           typename Service::Response& response, std::string& name);
  template <class Response>
  bool read(const std::string& service, const ServiceAsker::Result& result, Response& response);
  std::vector<std::string> candidates(const std::string& service) const;
  bool findMesh(std::string& uuid);
  bool deliverMesh(const std::string& name, const std::string& asked,
                   const mesh_msgs::MeshGeometryStamped::Ptr& mesh);
  void fetchTexture(const std::string& uuid, std::uint32_t index);
  bool belongs(const std::string& service, const std::string& name, const std::string& asked,
               std::string& given);
  void finish(const std::string& service, const std::string& name, bool accepted);

  std::shared_ptr<MeshInbox> inbox_;
  std::shared_ptr<MeshLoader> loader_;
  const ServiceNames names_;
  Cancellation cancellation_;
  ServiceLog log_;
  ServiceAsker asker_;
  mutable std::mutex mutex_;
  std::map<std::string, std::vector<std::string>> layers_;
};

}  // namespace rviz_mesh_plugin
