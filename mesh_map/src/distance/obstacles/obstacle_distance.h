#pragma once

#include <mesh_map/base/large_array.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/vector3.h"
#include "distance/obstacles/vertex_parts.h"
#include "distance/obstacles/window_propagation.h"

namespace mesh_map {

/// Distances along the surface from obstacles: lethal vertices, edges between two of them, and
/// faces between three. They are exact (see WindowPropagation), whatever the triangles are like.
///
/// What a vertex gets follows from the obstacles within the maximum distance of it alone. So there
/// is exactly one solution, however and in whichever order it is found, in how many parts the mesh
/// is divided among threads, and any part of it can be computed again by itself: see update().
class ObstacleDistance
{
 public:
  /// Distances beyond `max_distance` (meters, above 0, may be infinite) are infinite. The effort
  /// per vertex grows with the number of edges that it holds.
  ObstacleDistance(std::shared_ptr<const FastMarchingMesh> mesh, float max_distance);

  /// From everything: `lethal` holds one byte per vertex, not 0 for lethal ones. False where it was
  /// canceled; then nothing is known, and update() computes everything again.
  bool compute(ArrayView<std::uint8_t> lethal, const std::atomic<bool>* cancel = nullptr,
               unsigned threads = 0);

  /// The same result, bit for bit, computed again only around the vertices that have become lethal
  /// or ceased to be; or from everything, where that is more than this share of all vertices.
  /// Returns the vertices at which something has changed, ascending.
  std::vector<std::uint32_t> update(ArrayView<std::uint8_t> lethal,
                                    double most_share = MOST_UPDATED);

  /// Looking around changes takes two to three times as long per vertex as computing everything.
  static constexpr double MOST_UPDATED = 0.15;

  /// Per vertex: 0 on lethal ones, +inf beyond the maximum, and everywhere before compute(). Valid
  /// as long as this object.
  ArrayView<float> distances() const { return {distance_.data(), distance_.size()}; }

  /// Unit vector away from the obstacle in the plane of a face at the vertex; on lethal ones the
  /// mean of those around. Zero where there is none.
  std::array<float, 3> direction(std::uint32_t v) const;

  const FastMarchingMesh& mesh() const { return *mesh_; }

 private:
  /// A lethal vertex next to others, and where it is across the slabs.
  struct Obstacle
  {
    std::uint32_t vertex;
    double at;
  };
  struct Slab
  {
    WindowScope scope;
    std::vector<Obstacle> obstacles;
  };

  std::vector<Slab> slabs(const std::vector<std::uint32_t>& obstacles, std::size_t threads) const;
  bool solveIn(const std::vector<Slab>& slabs, std::size_t slab, WindowPropagation& propagation,
               const std::atomic<bool>* cancel);
  std::vector<std::uint32_t> clear(unsigned threads);
  bool isAtBorder(std::uint32_t v) const;
  double longestObstacle(std::uint32_t v) const;
  bool solveAround(const std::vector<std::uint32_t>& flipped, std::size_t most,
                   std::vector<std::uint32_t>& changed);
  std::vector<std::uint32_t> computeAnew(ArrayView<std::uint8_t> lethal);
  bool take(std::uint32_t v, const WindowPropagation& solved);
  Vector3 sourceDirection(std::uint32_t v) const;

  std::shared_ptr<const FastMarchingMesh> mesh_;
  float max_distance_;
  std::vector<std::uint8_t> lethal_;
  LargeArray<float> distance_;
  LargeArray<std::uint32_t>
      start_;  // PathStart, of vertices with a finite distance above 0; else 0
  bool known_ = false;
  VertexParts parts_;
  double longest_ = 0.0;  // at least the length of any edge between lethal vertices at borders
  std::unique_ptr<WindowPropagation> around_;  // of update()
  std::vector<float> gaps_;                    // of update(): the maximum distance in between
};

}  // namespace mesh_map
