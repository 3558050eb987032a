#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

namespace rviz_mesh_plugin {

/// Does tasks one after the other in lanes side by side, each on a thread of its own that starts
/// with its first task. To be used by one thread.
///
/// The destructor drops tasks that have not begun and does not wait for those that have: it is up
/// to them to end soon, and to own what they use. They are waited for at the end of the process,
/// but not forever.
class WorkLanes
{
 public:
  using Task = std::function<void()>;

  WorkLanes();
  ~WorkLanes();
  WorkLanes(const WorkLanes&) = delete;
  WorkLanes& operator=(const WorkLanes&) = delete;

  /// @param task must not throw. @throw std::system_error where no thread can be started
  void add(const std::string& lane, Task task);

 private:
  class Lane;
  class Leftovers;
  std::map<std::string, std::unique_ptr<Lane>> lanes_;
};

}  // namespace rviz_mesh_plugin
