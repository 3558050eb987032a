#pragma once

#include <string>

namespace rviz_mesh_plugin {

/// "rviz_mesh_plugin/<kind> <number>" with a number that no other name of this process has: OGRE
/// refuses a name that exists, and two displays must not share a resource.
std::string uniqueName(const std::string& kind);

}  // namespace rviz_mesh_plugin
