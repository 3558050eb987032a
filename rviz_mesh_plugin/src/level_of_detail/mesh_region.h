#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The box in which nearly all faces of a mesh lie. Stray vertices, far off, would make the cells
/// of any grid over the whole mesh useless.
struct MeshRegion : Bounds
{
  bool whole = true;  ///< no vertex lies outside

  /// The longest side.
  float extent() const
  {
    const auto lengths = sides();
    return *std::max_element(lengths.begin(), lengths.end());
  }

  /// False where all vertices are in one place: there is nothing to sort or to simplify. (1 /
  /// extent has to be a finite number.)
  bool hasExtent() const { return extent() > 1e-30f; }

  bool contains(const std::array<float, 3>& position) const { return clamp(position) == position; }

  /// The nearest position inside.
  std::array<float, 3> clamp(const std::array<float, 3>& position) const
  {
    std::array<float, 3> inside;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      inside[axis] = std::min(std::max(position[axis], lower[axis]), upper[axis]);
    }
    return inside;
  }
};

/// Judges by samples, in microseconds.
MeshRegion mainRegion(const MeshData& mesh);

/// The median edge, judged by samples; 0 where most edges have no length.
float typicalEdge(const MeshData& mesh);

}  // namespace rviz_mesh_plugin
