#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <ros/node_handle.h>

#include "map_server/file_watch.h"
#include "map_server/map_progress.h"

namespace rviz_mesh_plugin {

class MapServerRun;

/// Keeps an hdf5_map_server running for a file: starts it when the file is there and nobody is
/// writing it, and once more when it has failed and the file has changed. GUI thread only; nothing
/// here waits.
class MapSession
{
 public:
  /// @param find_program tells the path of hdf5_map_server; empty where there is none
  /// @param look at the file, see FileWatch
  explicit MapSession(std::function<std::string()> find_program, FileWatch::Look look = lookAtFile);
  ~MapSession();  ///< ends the process, see MapServerProcess

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
  /// What is known of the map.
  const MapProgress& progress() const { return progress_; }
  /// What became of the newest edit of a label, if there was one.
  const std::optional<LabelEvent>& label() const { return label_; }

 private:
  void start(ros::NodeHandle& nodes);

  std::function<std::string()> find_program_;
  std::string path_;
  FileWatch watch_;
  std::optional<FileStamp> tried_;  ///< the file that a process has been started for
  std::unique_ptr<MapServerRun> server_;
  std::string problem_;
  MapProgress progress_;
  std::optional<LabelEvent> label_;
};

}  // namespace rviz_mesh_plugin
