#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <osmesa_harness/render_fixture.h>

#include "base/mesh_data.h"
#include "conversion/mesh_conversion.h"
#include "labels/label_colors.h"
#include "level_of_detail/mesh_layout.h"
#include "meshes.h"
#include "rendering/labels/label_overlay.h"
#include "rendering/mesh_visual.h"

namespace test_labels {

inline rviz_mesh_plugin::MeshDataConstPtr flatGrid(std::uint32_t cells, double z = 0.0)
{
  return rviz_mesh_plugin::convert(test_meshes::terrain(cells, [z](double, double) { return z; }));
}

/// The faces of rows [first, last) of a grid.
inline std::vector<std::uint32_t> rows(std::uint32_t cells, std::uint32_t first, std::uint32_t last)
{
  std::vector<std::uint32_t> faces;
  for (std::uint32_t face = first * 2 * cells; face < last * 2 * cells; ++face) {
    faces.push_back(face);
  }
  return faces;
}

constexpr std::size_t ROW = 200 * 20;  ///< pixels of a row of faces of a grid of 10 x 10

inline osmesa_harness::Rgb colorOf(const std::string& label_class)
{
  const rviz_mesh_plugin::Rgba8 color = rviz_mesh_plugin::LabelColors().classColor(label_class);
  return {color.red, color.green, color.blue};
}

inline std::size_t put(rviz_mesh_plugin::LabelOverlay& overlay,
                       const rviz_mesh_plugin::LabelCluster& label)
{
  return overlay.setLabel(std::make_shared<rviz_mesh_plugin::LabelCluster>(label));
}

}  // namespace test_labels
