#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "threads/cancellation.h"

namespace rviz_mesh_plugin {

/// Of the end of the process with tasks that look up the addresses of hosts: the system may take
/// half a minute for that, and nothing can cancel it.
constexpr std::chrono::seconds NAME_PATIENCE(2);

/// The one kind of thread in the plugin. It does tasks one after the other, and starts with the
/// first. To be used by one thread at a time; a task may use it, too.
///
/// Nobody who uses it waits for it: what is canceled works to its end on its own. At the end of
/// the process all threads are canceled and joined, before anything is gone that they use. (The
/// library is linked so that it is never unloaded before that.)
class WorkThread
{
 public:
  /// Owns what it uses, throws nothing, and ends soon once it is canceled.
  using Task = std::function<void(const Cancellation& cancellation)>;

  /// @param name of the thread, as debuggers and top show it: at most 15 characters
  /// @param patience of the end of the process with a task that may hang in the system, where
  /// nothing can cancel it; such a thread is left to the system then
  explicit WorkThread(std::string name,
                      std::optional<std::chrono::milliseconds> patience = std::nullopt);
  ~WorkThread();
  WorkThread(const WorkThread&) = delete;
  WorkThread& operator=(const WorkThread&) = delete;

  /// @throw std::system_error where no thread can be started
  void add(Task task);

  /// Cancels the task that is being done, and drops those that have not begun. Those added later
  /// are done on another thread.
  void cancel();

  /// The same, and waits until the task that was being done has ended: for what uses libraries
  /// that the end of the process takes down before it joins threads. Does not wait in a task.
  void join();

  /// Cancels all threads of the process and waits for them, but not without patience. The end of
  /// the process does so, and the plugin when the application ends: before libraries are taken
  /// down that threads use.
  static void joinAll();

 private:
  struct Queue;
  class Running;

  const std::string name_;
  const std::optional<std::chrono::milliseconds> patience_;
  std::shared_ptr<Queue> queue_;  ///< null: there is no thread
};

}  // namespace rviz_mesh_plugin
