#pragma once

#include <string>

namespace rviz_mesh_plugin {

/// The order in which labels are listed and drawn: tree_2 before tree_10.
struct LabelLess
{
  bool operator()(const std::string& a, const std::string& b) const;
};

}  // namespace rviz_mesh_plugin
