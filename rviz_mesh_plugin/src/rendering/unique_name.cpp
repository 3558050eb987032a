#include "rendering/unique_name.h"

#include <atomic>

namespace rviz_mesh_plugin {

std::string uniqueName(const std::string& kind)
{
  static std::atomic<unsigned long> count{0};
  return "rviz_mesh_plugin/" + kind + " " + std::to_string(++count);
}

}  // namespace rviz_mesh_plugin
