#pragma once

#include <array>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// The box in which nearly all faces of a mesh lie. Stray vertices, far off, would make the cells
/// of any grid over the whole mesh useless.
struct MeshRegion : Bounds
{
  bool whole = true;  ///< no vertex lies outside

  /// The longest side.
  float extent() const;

  /// False where all vertices are in one place: there is nothing to sort or to simplify.
  bool hasExtent() const;

  bool contains(const std::array<float, 3>& position) const;

  /// The nearest position inside.
  std::array<float, 3> clamp(const std::array<float, 3>& position) const;
};

/// Judges by samples, in microseconds.
MeshRegion mainRegion(const MeshData& mesh);

/// The median edge, judged by samples; 0 where most edges have no length.
float typicalEdge(const MeshData& mesh);

}  // namespace rviz_mesh_plugin
