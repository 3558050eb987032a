#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <ros/time.h>

#include "navigation/server_connection.h"
#include "navigation/server_directory.h"
#include "navigation/server_watch.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// One navigation server: what it does, and what it is told. GUI thread only; nobody is waited for.
class NavigationServer
{
 public:
  using Time = ServerWatch::Time;

  /// @param name resolved
  explicit NavigationServer(const std::string& name);

  /// To be called regularly. @param directory where it may be listed
  void work(const ServerDirectory& directory, Time now);

  const ServerWatch& watch() const { return watch_; }
  ServerConnection& connection() { return connection_; }
  const ServerConnection& connection() const { return connection_; }

  /// Whether all of the simulated time is that of a clock which does not tick.
  bool timeStopped() const { return time_stopped_; }

  /// Cancels the goals of all of its actions, whoever sent them.
  /// @return what has become of that, a sentence
  std::string cancel();
  /// Whether it is known to be busy, or would hear of it.
  bool canCancel() const;

  /// Lets it forget what sensors have seen. @param services that do so
  void clear(const std::vector<std::string>& services);
  bool isClearing() const { return clearing_.isRunning(); }
  /// A sentence about the last time; empty: there was none.
  std::string clearReport(Time now) const;

 private:
  void askProcess(bool may_be_there, Time now);
  void lookAtClock(Time now);

  const std::string name_;
  ServerWatch watch_;
  ServerConnection connection_;

  BackgroundTask<ProcessState> process_{"ROS process", NAME_PATIENCE};
  std::optional<Time> process_asked_;

  std::optional<Time> ticked_;  ///< when ROS time was seen to go on
  ros::Time ros_time_;
  bool time_stopped_ = false;

  BackgroundTask<std::string> clearing_{"ROS clear", NAME_PATIENCE};
  Time clearing_since_;
  std::string clear_report_;
};

}  // namespace rviz_mesh_plugin
