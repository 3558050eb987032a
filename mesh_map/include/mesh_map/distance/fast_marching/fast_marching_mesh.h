#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/mesh/neighborhood.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// The corner of a face at some vertex: the other two vertices of that face. A face that names its
/// vertex twice leaves one edge, written as a == b; one that names it three times leaves nothing,
/// written as the vertex itself.
struct FastMarchingCorner
{
  std::uint32_t a, b;
};

/// What a front needs of a mesh: positions, and the corners of the faces around each vertex. Any
/// triangle soup will do. Immutable, so several threads may run fronts on it at once.
class FastMarchingMesh
{
 public:
  /// Throws std::invalid_argument where `vertex_faces` (rows of a Topology) does not belong to the
  /// mesh, or the mesh is too large for 32-bit indices of corners.
  FastMarchingMesh(const MeshView& mesh, const RowsView& vertex_faces, unsigned threads = 0);

  std::size_t vertexCount() const { return positions_.size(); }
  const PackedPosition& position(std::uint32_t v) const { return positions_[v]; }

  ArrayView<FastMarchingCorner> corners(std::uint32_t v) const
  {
    return {corners_.data() + offsets_[v], offsets_[v + 1] - offsets_[v]};
  }

  /// Do the faces around v form one fan? Then its corners are in order: b of each is a of the next.
  bool isFan(std::uint32_t v) const { return (kinds_[v] & FAN) != 0; }
  /// Is it a fan that goes all the way round? Everything else is a border, or not manifold.
  bool isClosed(std::uint32_t v) const { return (kinds_[v] & CLOSED) != 0; }
  /// Do its corners add up to more than a full turn, by more than BEND? Shortest ways bend there.
  bool isSaddle(std::uint32_t v) const { return (kinds_[v] & SADDLE) != 0; }

  static constexpr double BEND = 1e-6;  // radians

  /// The third corner of the one other face at the edge (a, b) of a face with the third corner
  /// `from`; NO_INDEX where there is none, or more than one.
  std::uint32_t across(std::uint32_t a, std::uint32_t b, std::uint32_t from) const
  {
    return isFan(a) ? acrossInFan(a, b, from) : acrossAnywhere(a, b, from);
  }

  /// Ask for memory that will be read soon, in this order: most of the time of a front would go
  /// into waiting for it.
  [[gnu::always_inline]] void prefetchRow(std::uint32_t v) const
  {
    __builtin_prefetch(&offsets_[v]);
  }
  [[gnu::always_inline]] void prefetchCorners(std::uint32_t v) const
  {
    __builtin_prefetch(corners_.data() + offsets_[v]);
    __builtin_prefetch(corners_.data() + offsets_[v + 1]);
  }
  [[gnu::always_inline]] void prefetchVertex(std::uint32_t v) const
  {
    __builtin_prefetch(&positions_[v]);
    __builtin_prefetch(&kinds_[v]);
  }

  /// Mean length of the sides of all faces; 1 where there are none.
  double meanEdge() const { return mean_edge_; }

  /// The largest fan that is put in order.
  static constexpr std::size_t MAX_FAN = 62;

 private:
  enum Kind : std::uint8_t
  {
    FAN = 1,
    CLOSED = 2,
    SADDLE = 4
  };

  std::uint32_t acrossInFan(std::uint32_t a, std::uint32_t b, std::uint32_t from) const
  {
    const ArrayView<FastMarchingCorner> row = corners(a);
    std::size_t i = 0;
    while (i < row.size() && row[i].a != b) {
      ++i;
    }
    if (i == row.size() || (i == 0 && !isClosed(a))) {
      return NO_INDEX;
    }
    const std::uint32_t before = row[i > 0 ? i - 1 : row.size() - 1].a;
    const std::uint32_t third = row[i].b != from ? row[i].b : before;
    return third != from ? third : NO_INDEX;
  }

  std::uint32_t acrossAnywhere(std::uint32_t a, std::uint32_t b, std::uint32_t from) const;
  void fillCorners(const MeshView& mesh, const RowsView& vertex_faces, std::uint32_t v);
  bool exceedsFullTurn(std::uint32_t v) const;
  static std::uint8_t orderFan(FastMarchingCorner* begin, std::size_t count, std::uint32_t v);

  LargeArray<PackedPosition> positions_;
  LargeArray<std::uint32_t> offsets_;
  LargeArray<FastMarchingCorner> corners_;
  std::vector<std::uint8_t> kinds_;
  double mean_edge_ = 1.0;
};

}  // namespace mesh_map
