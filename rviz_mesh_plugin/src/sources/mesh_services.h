#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "incoming/mesh_inbox.h"
#include "incoming/mesh_loader.h"
#include "sources/service_log.h"
#include "sources/service_names.h"

namespace rviz_mesh_plugin {

/// Asks the services of a map for what its topics do not bring. What they answer goes to the inbox
/// and the loader as if it had come as messages, checked in the same way. To be used by one thread;
/// no call waits for a service, not even the destructor.
///
/// Each thing is brought once until cancel(), however often it is requested. While no service of
/// the name answers, it is looked for once a second. Where a service refuses, or has nothing, and
/// the thing is requested still, it is asked again, more and more rarely: it may be loading its
/// map, or a layer may be computed only later.
class MeshServices
{
 public:
  /// Between two questions about the same thing; the first, and the greatest that this grows to.
  struct Pauses
  {
    std::chrono::milliseconds first{5000};
    std::chrono::milliseconds greatest{30000};
  };

  /// @param loader may be null where no mesh is ever requested
  MeshServices(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader, Pauses pauses);
  MeshServices(std::shared_ptr<MeshInbox> inbox, std::shared_ptr<MeshLoader> loader);
  ~MeshServices();
  MeshServices(const MeshServices&) = delete;
  MeshServices& operator=(const MeshServices&) = delete;

  /// Other names than before cancel everything. A service with an empty name is not asked.
  void setNames(const ServiceNames& names);

  /// @param uuid empty: the first that get_uuids or get_uuid names; where neither is there, what
  /// get_geometry answers
  void requestMesh(const std::string& uuid);
  void requestColors(const std::string& uuid);
  /// Then its textures, each once; further requests bring those that were refused.
  void requestMaterials(const std::string& uuid);
  /// Whether there are textures of its materials that a service has refused.
  bool missesTextures(const std::string& uuid) const;
  /// The names of its cost layers: see layers().
  void requestCosts(const std::string& uuid);
  void requestLayer(const std::string& uuid, const std::string& type);
  void requestLabels(const std::string& uuid);

  /// The layers that get_vertex_cost_layers named; empty while it has not answered.
  std::vector<std::string> layers(const std::string& uuid) const;

  /// Gives up and forgets everything; nothing that was asked before arrives any more.
  void cancel();

  using Report = ServiceReport;
  Report report() const;

 private:
  class Work;
  template <class Request>
  void request(const std::string& key, const Request& request);

  std::shared_ptr<MeshInbox> inbox_;
  std::shared_ptr<MeshLoader> loader_;
  const Pauses pauses_;
  ServiceNames names_;
  std::unique_ptr<Work> work_;  ///< null: nothing has been asked
  std::string failure_;         ///< why nothing can be asked
};

}  // namespace rviz_mesh_plugin
