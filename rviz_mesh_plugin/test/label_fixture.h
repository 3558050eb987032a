#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <osmesa_harness/render_fixture.h>

#include "meshes.h"
#include "rviz_mesh_plugin/mesh_conversion.h"
#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/mesh_layout.h"
#include "rviz_mesh_plugin/mesh_visual.h"

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

}  // namespace test_labels
