#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// A child process that ends with this object, and with this process in whatever way that ends.
/// GUI thread only (it is the death of the starting thread that ends the child); nothing waits.
class MapServerProcess
{
 public:
  /// Starts it without a shell, in this process's environment.
  /// @param environment "NAME=value", on top of that
  /// @param grace time to end, and before that to save
  MapServerProcess(const std::string& program, const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment,
                   std::chrono::milliseconds grace = std::chrono::seconds(15));

  /// Asks it to end (SIGTERM); if it has not when the grace is over, it is killed.
  ~MapServerProcess();
  MapServerProcess(const MapServerProcess&) = delete;
  MapServerProcess& operator=(const MapServerProcess&) = delete;

  /// 0 where it does not run.
  std::int64_t pid() const;
  bool ended() const;

  /// How it has ended, as "exit code 1" or "signal 9 (Killed)"; empty while it runs.
  const std::string& ending() const;

  /// Lines that it has written since the last call, on stdout and stderr.
  std::vector<std::string> takeLines();

  /// The newest lines, some 20 at most.
  const std::vector<std::string>& lastLines() const;

 private:
  class Child;
  Child* child_;
};

}  // namespace rviz_mesh_plugin
