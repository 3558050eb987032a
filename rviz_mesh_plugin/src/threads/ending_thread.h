#pragma once

#include <functional>
#include <memory>
#include <thread>

namespace rviz_mesh_plugin {

/// A thread that nobody has to wait for: when this is destroyed, the thread may work to its end on
/// its own. It is waited for when the process ends or the library is unloaded, at the latest, and
/// so has to end soon after it has been told to.
class EndingThread
{
 public:
  /// @param work owns all it uses, and throws nothing
  explicit EndingThread(std::function<void()> work);
  ~EndingThread();
  EndingThread(const EndingThread&) = delete;
  EndingThread& operator=(const EndingThread&) = delete;

 private:
  struct Running;
  std::unique_ptr<Running> running_;
};

}  // namespace rviz_mesh_plugin
