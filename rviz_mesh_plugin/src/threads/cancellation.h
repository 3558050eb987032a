#pragma once

#include <mesh_map/base/run_options.h>

#include <atomic>

namespace rviz_mesh_plugin {

/// Thrown where work is given up.
using mesh_map::Canceled;

/// @throw Canceled where the flag is there and set
inline void throwIfCanceled(const std::atomic<bool>* flag)
{
  if (mesh_map::isSet(flag)) {
    throw Canceled();
  }
}

/// A flag that also ends waiting. Thread safe; once set, it stays so.
class Cancellation
{
 public:
  Cancellation();  ///< @throw std::runtime_error without a free file descriptor
  ~Cancellation();
  Cancellation(const Cancellation&) = delete;
  Cancellation& operator=(const Cancellation&) = delete;

  void set();
  const std::atomic<bool>& flag() const { return flag_; }

  /// Waits until @a socket can be read or written (POLLIN, POLLOUT); false after the time.
  /// @param socket negative: only waits
  /// @param milliseconds negative: no limit
  /// @throw Canceled, std::runtime_error
  bool wait(int socket, short events, int milliseconds) const;

 private:
  std::atomic<bool> flag_{false};
  int event_;
};

}  // namespace rviz_mesh_plugin
