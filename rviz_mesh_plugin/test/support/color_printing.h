#pragma once

#include <ostream>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Prints colors of failing assertions; found by argument-dependent look-up.
inline void PrintTo(const Rgba8& color, std::ostream* stream)
{
  *stream << "(" << int(color.red) << ", " << int(color.green) << ", " << int(color.blue) << ", "
          << int(color.alpha) << ")";
}

}  // namespace rviz_mesh_plugin
