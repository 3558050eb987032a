#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include "map_server/map_progress.h"
#include "map_server/map_server_process.h"
#include "sources/mesh_source.h"

namespace rviz_mesh_plugin {

/// One run of hdf5_map_server for one file, in a namespace that nobody else has had. GUI thread
/// only.
class MapServerRun
{
 public:
  /// Starts it; does not wait for it.
  /// @param program an executable
  /// @param file absolute
  /// @param nodes for subscriptions to what it says of itself
  MapServerRun(const std::string& program, const std::string& file, ros::NodeHandle& nodes);
  ~MapServerRun();  ///< ends it, see MapServerProcess
  MapServerRun(const MapServerRun&) = delete;
  MapServerRun& operator=(const MapServerRun&) = delete;

  /// Takes over what it has said: updates progress, and label where there was an edit.
  void poll(MapProgress& progress, std::optional<LabelEvent>& label);

  const std::string& ns() const { return namespace_; }
  const MapServerProcess& process() const { return process_; }
  std::chrono::steady_clock::duration age() const;

  /// Why it has ended; empty while it runs.
  std::string ending() const;

  /// What displays have to be told.
  /// @param frame empty: as the file says
  MeshSource source(const std::string& frame) const;

 private:
  class Events;

  std::string namespace_;
  std::chrono::steady_clock::time_point started_;
  std::shared_ptr<Events> queue_;
  std::vector<ros::Subscriber> subscribers_;
  MapServerProcess process_;
};

/// The executable hdf5_map_server of the package mesh_msgs_hdf5, in the workspaces that the
/// environment names (CMAKE_PREFIX_PATH, ROS_PACKAGE_PATH) or in the system; empty where there is
/// none. Looks at a few file names only.
std::string findMapServer();

}  // namespace rviz_mesh_plugin
