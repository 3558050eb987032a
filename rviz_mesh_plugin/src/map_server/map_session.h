#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "map_server/file_watch.h"
#include "map_server/map_progress.h"
#include "map_server/map_server_process.h"
#include "ros_client/topic_receiver.h"
#include "sources/mesh_source.h"

namespace rviz_mesh_plugin {

/// One run of hdf5_map_server for one file, in a namespace that nobody else has had; it ends with
/// this object, see MapServerProcess. GUI thread only.
class MapServerRun
{
 public:
  /// Starts it; does not wait for it.
  /// @param program an executable
  /// @param file absolute
  /// @param nodes for subscriptions to what it says of itself
  MapServerRun(const std::string& program, const std::string& file, ros::NodeHandle& nodes);

  /// Takes over what it has said; to be called often.
  void poll();

  const std::string& ns() const { return namespace_; }
  const MapServerProcess& process() const { return *process_; }
  /// What is known of the map.
  const MapProgress& progress() const { return progress_; }
  /// What became of the newest edit of a label, if there was one.
  const std::optional<LabelEvent>& label() const { return label_; }
  std::chrono::steady_clock::duration age() const;

  /// Why it has ended; empty while it runs.
  std::string ending() const;

  /// What displays have to be told.
  /// @param frame empty: as the file says
  MeshSource source(const std::string& frame) const;

 private:
  struct Events;

  std::string namespace_;
  std::chrono::steady_clock::time_point started_;
  std::shared_ptr<Events> events_;
  TopicReceiver receiver_;
  std::vector<TopicReceiver::Subscription> subscriptions_;
  MapServerProcess::Owner process_;
  MapProgress progress_;
  std::optional<LabelEvent> label_;
};

/// The executable hdf5_map_server of the package mesh_msgs_hdf5, in the workspaces that the
/// environment names (CMAKE_PREFIX_PATH, ROS_PACKAGE_PATH) or in the system; empty where there is
/// none. Looks at a few file names only.
std::string findMapServer();

/// Keeps an hdf5_map_server running for a file: starts it when the file is there and nobody is
/// writing it, and once more when it has failed and the file has changed. The process ends with
/// this object, see MapServerProcess. GUI thread only; nothing here waits.
class MapSession
{
 public:
  /// @param find_program tells the path of hdf5_map_server; empty where there is none
  /// @param look at the file, see FileWatch
  explicit MapSession(std::function<std::string()> find_program, FileWatch::Look look = lookAtFile);

  /// Ends what is running. Another file is served a moment after this.
  /// @param path as the user gave it, see resolvedPath()
  void setFile(const std::string& path);

  /// Starts a process that has failed once more.
  void retry();

  /// To be called often.
  /// @param nodes for subscriptions; called back in any thread
  void update(ros::NodeHandle& nodes);

  const FileState& file() const { return watch_.file(); }
  /// Why nothing newer is known of it, in a sentence; else empty.
  const std::string& lookProblem() const { return watch_.problem(); }
  /// What has been started last; null where nothing has.
  const MapServerRun* server() const { return server_.get(); }
  /// Why nothing can be started, in a sentence; empty if nothing prevents it.
  const std::string& problem() const { return problem_; }

 private:
  void start(ros::NodeHandle& nodes);

  std::function<std::string()> find_program_;
  std::string path_;
  FileWatch watch_;
  std::optional<FileStamp> tried_;  ///< the file that a process has been started for
  std::unique_ptr<MapServerRun> server_;
  std::string problem_;
};

}  // namespace rviz_mesh_plugin
