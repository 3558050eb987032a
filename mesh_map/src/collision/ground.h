#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "collision/body_band.h"

namespace mesh_map {

/// Bit of faces that have cells, beside those of covered corners.
constexpr std::uint8_t HAS_CELLS = 8;

/// For each vertex a number that is that of all vertices which faces join it with: what is another
/// surface is never reached.
std::vector<std::uint32_t> surfacesOf(const MeshView& mesh);

/// The ground around one vertex after the other, see collisions().
///
/// Around a body with a large radius there are thousands of faces, so what is found out of a corner
/// is kept for the other faces around it.
class Ground
{
 public:
  /// `covered`: HAS_CELLS of each face. `closed`: 1 for vertices that collide without a radius.
  /// `rise`: how far ground may be above a vertex at that vertex.
  Ground(const MeshView& mesh, const RowsView& vertex_faces,
         const std::vector<std::uint8_t>& covered, const std::vector<std::uint8_t>& closed,
         double rise);

  /// Begins with another vertex, at which the body stands. No face is wanted yet.
  void begin(std::uint32_t vertex, const VertexBand& body);

  /// Wants a face to be ground.
  void want(std::uint32_t face);

  /// Whether all corners of a triangle (9 floats) are low enough for ground.
  bool isLow(const float* corners) const;

  /// Whether all faces that are wanted are ground.
  bool hasAllWanted();

 private:
  struct Rounds  // the last one in which something was so
  {
    std::uint32_t known = 0, reached = 0;
  };

  bool isLowPoint(const float* point) const
  {
    const double height = body_->heightOf(point);
    return height <= rise_ || height <= rise_ + body_->distanceTo(point);
  }
  unsigned cornerOf(std::uint32_t vertex);
  bool isGround(std::size_t face);
  void reachCorners(std::size_t face);

  MeshView mesh_;
  RowsView vertex_faces_;
  const std::vector<std::uint8_t>& covered_;
  const std::vector<std::uint8_t>& closed_;
  double rise_;
  const VertexBand* body_ = nullptr;
  std::uint32_t vertex_ = 0, round_ = 0;
  std::size_t missing_ = 0;
  std::vector<Rounds> vertices_, faces_;  // of faces, `known` are those that are wanted
  std::vector<std::uint8_t> corners_;     // bits of vertices that are known
  std::vector<std::uint32_t> reached_;
};

}  // namespace mesh_map
