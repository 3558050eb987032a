#pragma once

#include <atomic>
#include <string>

namespace rviz_mesh_plugin {

/// "rviz_mesh_plugin/<kind> <number>" with a number that no other name of this process has: OGRE
/// refuses a name that exists, and two displays must not share a resource.
inline std::string uniqueName(const std::string& kind)
{
  static std::atomic<unsigned long> count{0};
  return "rviz_mesh_plugin/" + kind + " " + std::to_string(++count);
}

}  // namespace rviz_mesh_plugin
