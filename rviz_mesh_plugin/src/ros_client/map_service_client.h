#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "incoming/attribute_queue.h"
#include "incoming/mesh_loader.h"
#include "ros_client/service_call.h"
#include "ros_client/service_log.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

/// Asks the services of a map for what its topics do not bring. What they answer goes to the queue
/// and the loader as if it had come as messages, checked in the same way. To be used by one thread;
/// no call waits for a service, not even the destructor.
///
/// Each thing is brought once until cancel(), however often it is requested. While no service of
/// the name answers, it is looked for once a second. Where a service refuses, or has nothing, and
/// the thing is requested still, it is asked again, more and more rarely: it may be loading its
/// map, or a layer may be computed only later.
class MapServiceClient
{
 public:
  using Milliseconds = std::chrono::milliseconds;

  /// @param loader may be null where no mesh is ever requested
  /// @param first_pause between two questions about the same thing
  /// @param greatest_pause that this grows to
  MapServiceClient(std::shared_ptr<AttributeQueue> queue, std::shared_ptr<MeshLoader> loader,
                   Milliseconds first_pause = Milliseconds(5000),
                   Milliseconds greatest_pause = Milliseconds(30000));

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

  ServiceReport report() const;

 private:
  class Question;
  class Errand;
  struct Work;
  struct Turn;

  /// @param lane what is asked in one lane is asked one after the other
  /// @param item of what is asked, where there are several
  void request(const std::string& lane, bool (Errand::*errand)(), const std::string& uuid,
               const std::string& item = std::string());

  std::shared_ptr<AttributeQueue> queue_;
  std::shared_ptr<MeshLoader> loader_;
  const Milliseconds first_pause_;
  const Milliseconds greatest_pause_;
  ServiceNames names_;
  std::shared_ptr<Work> work_;  ///< null: nothing has been asked
  std::map<std::string, std::shared_ptr<Turn>> turns_;
  std::map<std::string, WorkThread> lanes_;
  std::string failure_;  ///< why nothing can be asked
};

}  // namespace rviz_mesh_plugin
