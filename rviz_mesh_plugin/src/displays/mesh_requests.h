#pragma once

#include <chrono>
#include <map>
#include <set>
#include <string>

namespace rviz_mesh_plugin {

class MeshSources;
class MeshProperties;
class MeshStore;

/// Asks services for what a mesh display needs and its topics do not bring.
class MeshRequests
{
 public:
  using Clock = std::chrono::steady_clock;

  /// All of them have to outlive this.
  MeshRequests(MeshSources& sources, const MeshProperties& properties, const MeshStore& store)
      : sources_(sources), properties_(properties), store_(store)
  {
  }

  /// Topics get this much time, where they are named.
  static constexpr std::chrono::milliseconds PATIENCE{1000};

  /// To be called regularly.
  void update(Clock::time_point now);

  /// Begins anew: everything is asked again that is still missing.
  void restart()
  {
    since_.clear();
    uuids_.clear();
    mesh_asked_ = false;
  }

 private:
  void forgetGone();
  void requestAttributes(Clock::time_point now, const std::string& uuid);
  bool due(const std::string& what, bool needed, bool has_topic, Clock::time_point now);

  MeshSources& sources_;
  const MeshProperties& properties_;
  const MeshStore& store_;
  std::map<std::string, Clock::time_point> since_;  ///< when what is missing was missed first
  std::set<std::string> uuids_;                     ///< of the meshes that there were
  bool mesh_asked_ = false;
};

}  // namespace rviz_mesh_plugin
