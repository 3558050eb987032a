#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// What the ROS master knows of navigation servers: which there are, and of one of them the names
/// of its planners and controllers. GUI thread only; nothing waits for the master.
class ServerDirectory
{
 public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::seconds INTERVAL{3};  ///< between two questions to the master

  /// To be called regularly. @param server of which more is asked, resolved; another one is asked
  /// for at once
  void update(Clock::time_point now, const std::string& server);

  /// Whether the master has answered once, or could not.
  bool asked() const { return asked_; }
  /// Why it could not be asked the last time; else empty.
  const std::string& problem() const { return problem_; }

  /// Those that are registered, sorted: dead ones are among them until somebody cleans up.
  const std::vector<std::string>& servers() const { return known_.servers; }
  bool lists(const std::string& server) const;

  /// Of the server that was asked for: empty where it tells none.
  const std::vector<std::string>& planners() const { return known_.planners; }
  const std::vector<std::string>& controllers() const { return known_.controllers; }
  /// Services of it that make it forget what sensors have seen.
  const std::vector<std::string>& clearServices() const { return known_.clear_services; }

  /// Which server is meant where none is named: the only one there is, or the only one of a usual
  /// name; the first usual name where there is none, and empty where several are as likely.
  std::string usualServer() const;

 private:
  struct Known
  {
    std::string server;
    std::vector<std::string> servers;
    std::vector<std::string> planners;
    std::vector<std::string> controllers;
    std::vector<std::string> clear_services;
  };
  static Known ask(const std::string& server, const Cancellation& cancellation);

  Known known_;
  std::optional<Clock::time_point> asked_at_;
  std::string asked_for_;
  bool asked_ = false;
  std::string problem_;
  BackgroundTask<Known> question_{"ROS servers", NAME_PATIENCE};
};

}  // namespace rviz_mesh_plugin
