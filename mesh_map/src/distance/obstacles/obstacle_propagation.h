#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "distance/fast_marching/fast_marching_triangle.h"
#include "distance/obstacles/distance_queue.h"
#include "distance/obstacles/obstacle_distance.h"
#include "distance/obstacles/vertex_fan.h"

namespace mesh_map {

/// The next larger float of one that is finite and >= 0: what every step of a front adds at least,
/// so that "nearer to the obstacle" is an order without ties along any way.
inline float above(float distance)
{
  return floatOf(bitsOf(distance) + 1);
}

/// Calls body(u) for the neighbors u of v; one may come several times.
template <class Body>
void forNeighbors(const FastMarchingMesh& mesh, std::uint32_t v, Body&& body)
{
  for (const FastMarchingCorner& corner : mesh.corners(v)) {
    body(corner.a);
    body(corner.b);
  }
}

/// The point of the segment from a to b that is nearest to p.
inline Vector2 nearestOnSegment(Vector2 a, Vector2 b, Vector2 p)
{
  const Vector2 side = b - a;
  const double squared = dot(side, side);
  const double within = std::min(1.0, std::max(0.0, dot(p - a, side) / squared));
  return squared > 0.0 ? a + within * side : a;
}

/// Where a way is shorter than two known distances allow, by this part of the edge, the surface is
/// too curved for what was unfolded, and the two distances count.
constexpr double SHORTER_THAN_KNOWN = 0.02;

/// The least distance of the third corner of a triangle in the plane, (x, y) beyond the base on the
/// x axis, from anything that is u from its one end, at the origin, and v from its other end, at
/// (base, 0); 0 where the way does not cross the base.
inline double leastDistance(double u, double v, double base, double x, double y)
{
  FastMarchingSource source;
  findSource(u, v, base, source);
  const double along = x - source.along, height = y + source.depth;
  return source.crosses(base, x, y) ? std::sqrt(along * along + height * height) : 0.0;
}

/// One run of a front over a part of the mesh: the vertices with its stamp. A vertex that has its
/// distance passes on to its neighbors what it knows of the obstacle.
class ObstacleDistance::Propagation
{
 public:
  /// What lies outside of the part is held fast, or, while it changes in other threads, not looked
  /// at.
  Propagation(ObstacleDistance& owner, std::uint8_t stamp, bool sees_outside);

  /// A vertex that has a distance and passes it on.
  void start(std::uint32_t vertex) { queue_.push(owner_.distance_[vertex], vertex); }

  /// False where it was canceled.
  bool run(const std::atomic<bool>* cancel);

 private:
  /// A piece of the obstacle, or a vertex where the way to it bends, `offset` from it.
  struct Piece
  {
    Vector2 a, b;
    double offset;
  };
  /// A neighbor beyond which the obstacle cannot be seen, and the way from what lies behind.
  struct Bound
  {
    Vector2 direction;
    double length;
    Piece piece;
  };

  void prefetch() const;
  void propagate(std::uint32_t vertex);
  bool hasOpenNeighbor() const;
  void passAcrossFromLethal();
  void offerAcross(std::size_t before, Vector2 before_place, std::size_t k, Vector2 place,
                   bool is_past);
  void look(std::size_t axis, std::size_t side, bool toward);
  const Bound* hiding(Vector2 place, Vector2 nearest) const;
  void findAcross();
  void addBound(const FanStep& step, Vector2 place, Vector2 nearest);
  void offerSeen(const FanStep& step, Vector2 place, Vector2 nearest, const Piece& piece);
  double atLeast(double distance, const FanStep& step) const;
  /// Of the side between two vertices.
  double squaredLength(std::uint32_t a, std::uint32_t b) const
  {
    const Vector3 side = between(mesh_.position(a), mesh_.position(b));
    return dot(side, side);
  }
  double atLeastAcross(double distance, std::size_t k, Vector2 place, Vector2 seen) const;
  void offerBent(std::size_t k);

  bool isInPart(std::uint32_t v) const { return owner_.stamps_[v] == stamp_; }
  /// Was its distance known before that of the vertex that is looked at?
  bool isBefore(std::uint32_t v) const
  {
    const float distance = owner_.distance_[v];
    return distance < distance_ || (distance == distance_ && v < vertex_);
  }
  bool isKnown(std::uint32_t v) const { return (sees_outside_ || isInPart(v)) && isBefore(v); }
  bool isOpen(std::uint32_t v) const { return isInPart(v) && !isBefore(v); }
  bool isBetter(float distance, std::uint32_t v, std::uint32_t axis, std::uint32_t side) const;
  void take(std::uint32_t v, float distance, const Source& source);

  ObstacleDistance& owner_;
  const FastMarchingMesh& mesh_;
  DistanceQueue queue_;
  std::uint8_t stamp_;
  bool sees_outside_;

  // Of the vertex that is looked at:
  VertexFan fan_;
  std::uint32_t vertex_ = 0;
  float distance_ = 0.0f;
  std::vector<FastMarchingAcross> across_;  // those to which it may have something to tell
  Piece piece_{};                           // mirrored where the walk goes away from `side`
  std::vector<std::uint8_t> seen_;          // per node: is it reached without a bend?
  std::vector<Bound> bounds_;
};

}  // namespace mesh_map
