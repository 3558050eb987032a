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

namespace mesh_map {

class VertexFan;

/// Distances along the surface from obstacles: lethal vertices, edges between two of them, and
/// faces between three.
///
/// A front carries with each vertex not only how far the obstacle is, but also which piece of it
/// (a point or an edge) is nearest, and where that lies when the faces in between are unfolded into
/// a plane (J. Mitchell, D. Mount, C. Papadimitriou: The Discrete Geodesic Problem, 1987). So a
/// front that comes from an edge stays straight, one that comes from a corner stays round. Where
/// the way has to bend, at a border or between faces that form a saddle, the vertex there becomes
/// the source.
///
/// A vertex hears of the obstacle from neighbors that are nearer to it, and, where its corner of a
/// face is obtuse, also from the vertex across the opposite edge, since both ends of that edge may
/// be farther. Behind several slivers one after the other there may be no such vertex: then the
/// distance comes out too long, but never longer than the way along edges.
///
/// What a vertex gets is a function of these vertices with smaller distances (ties: none, since
/// every step adds at least one unit in the last place). So there is exactly one solution, however
/// and in whichever order it is found, and any part of it can be computed again with what lies
/// around it held fast: see update().
class ObstacleDistance
{
 public:
  /// Distances beyond `max_distance` (meters, above 0, may be infinite) are infinite.
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

  /// Looking around changes takes some ten times as long per vertex as computing everything.
  static constexpr double MOST_UPDATED = 0.05;

  /// Per vertex: 0 on lethal ones, +inf beyond the maximum, and everywhere before compute(). Valid
  /// as long as this object.
  ArrayView<float> distances() const { return {distance_.data(), distance_.size()}; }

  /// Unit vector away from the obstacle in the plane of a face at the vertex; on lethal ones the
  /// mean of those around. Zero where there is none.
  std::array<float, 3> direction(std::uint32_t v) const;

  const FastMarchingMesh& mesh() const { return *mesh_; }

 private:
  /// The nearest piece of the obstacle, from a to b, as seen from a vertex v: in a plane with v at
  /// the origin, the vertex `axis` on the x axis, and the face (v, axis, side) where y > 0. The
  /// way goes to that piece, and `offset` farther.
  struct Source
  {
    float offset;
    float ax, ay, bx, by;
    std::uint32_t axis, side;
  };
  class Propagation;

  void seed(std::uint32_t v, VertexFan& fan);
  void seedFrom(std::uint32_t lethal, std::uint32_t v, std::uint32_t side, VertexFan& fan);
  void offerSeed(std::uint32_t v, std::uint32_t axis, std::uint32_t side, Vector2 a, Vector2 b);
  bool solveParts(const std::atomic<bool>* cancel, unsigned threads);
  bool solveRegion(std::size_t most, std::vector<std::uint32_t>& changed);
  std::vector<std::uint32_t> computeAnew(ArrayView<std::uint8_t> lethal);
  bool isChanged(std::uint32_t v, float distance, const Source& source) const;
  bool passesOn(std::uint32_t v) const;
  void runRegion();
  void markRim(bool mark);
  bool isInside(std::uint32_t v) const;
  void addToRegion(std::uint32_t v);
  bool growRegion(const std::vector<std::uint32_t>& from, double reach, std::size_t most);
  std::uint8_t newStamps(std::size_t count);
  /// What has changed is rarely within three edges of the end of this, and so is solved only once.
  double reach() const { return 1.05 * max_distance_ + 4.5 * mesh_->meanEdge(); }
  static Source sourceOf(double offset, const Vector2& a, const Vector2& b, std::uint32_t axis,
                         std::uint32_t side);
  Vector3 sourceDirection(std::uint32_t v) const;

  std::shared_ptr<const FastMarchingMesh> mesh_;
  float max_distance_;
  std::vector<std::uint8_t> lethal_;
  LargeArray<float> distance_;
  LargeArray<Source> source_;  // of vertices with a finite distance above 0
  bool known_ = false;

  std::vector<std::uint8_t>
      stamps_;  // which part of the mesh a vertex was in last: small, for caches
  std::uint8_t stamp_ = 0;
  std::vector<std::uint32_t> region_;  // the vertices with this stamp
  std::vector<std::uint8_t> at_rim_;   // of the region: 1 next to others, 2 next to 1; else 0
  std::vector<float> lengths_;         // scratch of growRegion: infinite
};

}  // namespace mesh_map
