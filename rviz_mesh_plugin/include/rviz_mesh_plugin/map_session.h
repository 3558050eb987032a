#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <ros/node_handle.h>

#include "rviz_mesh_plugin/map_file.h"
#include "rviz_mesh_plugin/map_progress.h"

namespace rviz_mesh_plugin {

class MapServer;

/// Keeps an hdf5_map_server running for a file: starts it when the file is there and nobody is
/// writing it, and once more when it has failed and the file has changed. GUI thread only; nothing
/// here waits.
class MapSession
{
 public:
  /// @param find_program tells the path of hdf5_map_server; empty where there is none
  explicit MapSession(std::function<std::string()> find_program);
  ~MapSession();  ///< ends the process, see MapServerProcess

  /// Ends what is running. Another file is served a moment after this.
  /// @param path as the user gave it, see resolvedPath()
  void setFile(const std::string& path);
  const std::string& path() const { return path_; }

  /// Starts a process that has failed once more.
  void retry();

  /// To be called often: looks at the file about once a second.
  /// @param nodes for subscriptions; called back in any thread
  void update(ros::NodeHandle& nodes);

  const MapFile& file() const { return file_; }
  /// What has been started last; null where nothing has.
  const MapServer* server() const { return server_.get(); }
  /// Why nothing can be started, in a sentence; empty if nothing prevents it.
  const std::string& problem() const { return problem_; }
  /// What is known of the map.
  const MapProgress& progress() const { return progress_; }
  /// What became of the newest edit of a label, if there was one.
  const std::optional<LabelEvent>& label() const { return label_; }

 private:
  using Clock = std::chrono::steady_clock;

  void look();
  void start(ros::NodeHandle& nodes);

  std::function<std::string()> find_program_;
  std::string path_;
  MapFile file_;
  Clock::time_point chosen_{};      ///< when setFile() was called
  Clock::time_point next_look_{};   ///< at the file
  bool settled_ = false;            ///< the file was the same at two looks
  std::optional<FileStamp> tried_;  ///< the file that a process has been started for
  std::unique_ptr<MapServer> server_;
  std::string problem_;
  MapProgress progress_;
  std::optional<LabelEvent> label_;
};

}  // namespace rviz_mesh_plugin
