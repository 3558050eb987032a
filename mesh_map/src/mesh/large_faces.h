#pragma once

#include <mesh_map/base/array_view.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/vector3.h"

namespace mesh_map {

/// The lowest and the highest of some heights.
class HeightRange
{
 public:
  void add(float height)
  {
    lowest_ = std::min(lowest_, height);
    highest_ = std::max(highest_, height);
  }
  /// Whether these two change nothing.
  bool holds(float lowest, float highest) const { return lowest_ <= lowest && highest <= highest_; }
  /// Highest minus lowest; NaN of no heights.
  float size() const
  {
    return lowest_ <= highest_ ? highest_ - lowest_ : std::numeric_limits<float>::quiet_NaN();
  }

 private:
  float lowest_ = std::numeric_limits<float>::infinity();
  float highest_ = -std::numeric_limits<float>::infinity();
};

/// The faces of a mesh with a side longer than a radius: near a vertex, no other vertex may tell
/// how their surface rises.
class LargeFaces
{
 public:
  /// There are none.
  LargeFaces() = default;
  /// \param mesh, vertex_faces  Have to outlive this object; rows of the faces around each vertex.
  /// \param up       Of length 1: heights are along it.
  LargeFaces(const MeshView& mesh, const RowsView& vertex_faces, double radius, const Vector3& up,
             unsigned threads);

  /// Per vertex: whether one is at it; no vertices where there is none at all.
  ArrayView<std::uint8_t> touched() const { return touched_; }

  /// Adds the least and the largest height that the surface of those at vertex `at`, which is
  /// within the radius around vertex `center` and touched, has within it; other corners count as
  /// vertices.
  void addHeights(std::size_t center, std::size_t at, HeightRange& range) const;

 private:
  void addHeightsOf(std::size_t face, const Vector3& center, HeightRange& range) const;

  MeshView mesh_;
  RowsView vertex_faces_;
  double radius_ = 0.0;
  Vector3 up_ = {0.0, 0.0, 1.0};
  std::vector<std::uint8_t> large_;  // per face
  std::vector<std::uint8_t>
      touched_;  // per vertex: a large face is at it; empty where none is large
};

}  // namespace mesh_map
