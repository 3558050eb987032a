#pragma once

#include <cstdint>

#include <QColor>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

inline QColor toQColor(const Rgba8& color)
{
  return {color.red, color.green, color.blue};
}

inline Rgba8 toRgba8(const QColor& color)
{
  return {static_cast<std::uint8_t>(color.red()), static_cast<std::uint8_t>(color.green()),
          static_cast<std::uint8_t>(color.blue()), 255};
}

}  // namespace rviz_mesh_plugin
