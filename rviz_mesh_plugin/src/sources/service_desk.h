#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "incoming/mesh_inbox.h"
#include "incoming/mesh_loader.h"
#include "sources/service_log.h"
#include "sources/service_names.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {

/// Asks the services of a map and hands their answers over; each function waits until that is done.
/// Threads may share a desk, and outlive everything else: it owns what it uses.
///
/// They return whether that was all there is: if not, a service refuses, or has nothing (yet), and
/// they may be called again. They throw Cancelled after cancel().
class ServiceDesk
{
 public:
  ServiceDesk(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader,
              ServiceNames names);
  ~ServiceDesk();

  bool fetchMesh(std::string uuid, bool again);
  bool fetchColors(const std::string& uuid, bool again);
  /// And textures; later only those of them that were refused.
  bool fetchMaterials(const std::string& uuid, bool again);
  bool fetchLayerNames(const std::string& uuid, bool again);
  bool fetchLayer(const std::string& uuid, const std::string& type, bool again);
  bool fetchLabels(const std::string& uuid, bool again);

  /// Ends all work; nothing is handed over any more.
  void cancel();

  std::vector<std::string> layers(const std::string& uuid) const;
  /// Whether there are textures that were refused.
  bool missesTextures(const std::string& uuid) const;
  ServiceLog& log() { return log_; }

 private:
  class ServiceDialog;

  /// @return whether the mesh has been brought without a uuid; else, an empty uuid: refused
  bool findMesh(std::string& uuid);
  bool deliverMesh(const std::string& name, const std::string& asked,
                   const mesh_msgs::MeshGeometryStamped::Ptr& mesh);
  bool fetchTextures(const std::string& uuid, const std::set<std::uint32_t>& indices, bool again);
  bool fetchTexture(const std::string& uuid, std::uint32_t index);

  std::shared_ptr<MeshInbox> inbox_;
  std::shared_ptr<MeshLoader> loader_;
  const ServiceNames names_;
  Cancellation cancellation_;
  ServiceLog log_;
  std::unique_ptr<ServiceDialog> dialog_;
  mutable std::mutex mutex_;
  std::map<std::string, std::vector<std::string>> layers_;
  std::map<std::string, std::set<std::uint32_t>> missing_textures_;
};

}  // namespace rviz_mesh_plugin
