#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "navigation/server_watch.h"

namespace rviz_mesh_plugin {

/// Topics of a server's actions, from and to it. GUI thread only, and that waits for nobody: what
/// asks the ROS master (roscpp does so again and again while there is none) is done on a thread.
class ServerConnection
{
 public:
  /// @param server resolved. @throw std::system_error without a thread
  explicit ServerConnection(const std::string& server);
  ~ServerConnection();
  ServerConnection(const ServerConnection&) = delete;
  ServerConnection& operator=(const ServerConnection&) = delete;

  /// Hands over what has come since the last time, in the order and with the times of its coming.
  void deliver(ServerWatch& watch);

  /// Cancels all goals of an action.
  /// @return whether somebody is there to be told
  bool cancel(NavigationAction action);
  /// Whether somebody would be told, for any of the actions.
  bool hearsCancel() const;

  /// Tells those who send goals that are clicked (goal_bridge) which planner and controller to ask
  /// for; empty: their own, else the server's first. Who comes later is told as well.
  void choose(const std::string& planner, const std::string& controller);

  /// How many of those are told.
  std::size_t choiceReceivers() const;

 private:
  struct Events;
  struct Link;
  struct Shared;

  static void connect(const std::string& server, Shared& shared);

  std::shared_ptr<Shared> shared_;
};

}  // namespace rviz_mesh_plugin
