#pragma once

#include <mesh_map/base/large_array.h>
#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "base/float_bits.h"
#include "distance/obstacles/distance_queue.h"
#include "distance/obstacles/passed_window.h"
#include "distance/obstacles/window.h"
#include "mesh/packed_position.h"

namespace mesh_map {

/// What a vertex knows of the obstacle, as one number: the distance, and below it the way there.
/// Of two the smaller one is better; of ways of the same length one is so, too, so that there is
/// one solution. The way is a corner of the vertex (its place in the row of the mesh), and where on
/// the edge opposite to it the way crosses.
using WindowLabel = std::uint64_t;

/// At an infinite distance.
constexpr WindowLabel NO_LABEL = WindowLabel{0x7f800000u} << 32 | 0xffffffffu;

inline float distanceOf(WindowLabel label)
{
  return floatOf(static_cast<std::uint32_t>(label >> 32));
}

inline WindowLabel labelOf(float distance, std::uint32_t start)
{
  return WindowLabel{bitsOf(distance)} << 32 | start;
}

/// A corner of a vertex, and where the way crosses the opposite edge, from 0 at its a to 1 at b.
struct PathStart
{
  std::uint32_t corner;
  double along;
  double step;  // of along, as it is packed

  static std::uint32_t pack(std::size_t corners, std::uint32_t corner, double along);
  static PathStart unpack(std::size_t corners, std::uint32_t packed);
};

/// Where distances are wanted: between two places across an axis, and of the vertices that have no
/// gap, where gaps are given: lower bounds of their distances from the others.
struct WindowScope
{
  unsigned axis = 0;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  const float* gaps = nullptr;  // per vertex

  bool isAll() const { return gaps == nullptr && std::isinf(low) && std::isinf(high); }

  /// Where a vertex is along the axis.
  double at(const PackedPosition& p) const { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }
  /// Between the two places. Of scopes beside each other, what is at the place is in the upper one.
  bool isIn(const PackedPosition& p) const
  {
    return (std::isinf(low) || at(p) >= low) && (std::isinf(high) || at(p) < high);
  }
};

/// Exact distances along the surface from lethal vertices, edges between two of them, and faces
/// between three, by the propagation of windows in the order of their distances. One that another
/// way is shorter than, all over its part of the edge, ends (S. Xin, G. Wang: Improving Chen and
/// Han's Algorithm on the Discrete Geodesic Problem, 2009). Where a way can bend, at a border or a
/// vertex with more than a full turn around it, new windows start. Any triangle soup will do.
///
/// A label is the least of what all ways offer, each of which depends on nothing but the faces
/// that it passes and the labels of the vertices where it bends: it does not depend on what else
/// is propagated, so any part of the mesh can be solved alone, with the obstacles within the
/// maximum of it.
class WindowPropagation
{
 public:
  WindowPropagation(const FastMarchingMesh& mesh, double max_distance);

  /// `lethal` holds one byte per vertex, not 0 for lethal ones, and `obstacles` those of them that
  /// are next to others, and that the scope may be reached from (or more). False where it was
  /// canceled.
  bool run(ArrayView<std::uint8_t> lethal, ArrayView<std::uint32_t> obstacles,
           const WindowScope& scope, const std::atomic<bool>* cancel);

  /// NO_LABEL where nothing within the maximum is, 0 of obstacles.
  WindowLabel label(std::uint32_t v) const { return labels_[v]; }
  /// Obstacles, and all other vertices that have a label.
  ArrayView<std::uint32_t> reached() const { return reached_; }

 private:
  /// A corner of a fan, its angle, and the limit to its right.
  struct Sector
  {
    FastMarchingCorner corner;
    Vector2 turn, right;
    bool is_hidden;
  };

  void start(ArrayView<std::uint32_t> obstacles);
  void startStrips(std::uint32_t v);
  bool isInScope(std::uint32_t obstacle) const;
  bool mayLeave(std::uint32_t v, double offset) const;
  void startStrip(std::uint32_t right, std::uint32_t left, std::uint32_t beyond);
  void leaveVertex(std::uint32_t v);
  void offerAlongEdges(std::uint32_t v, double distance);
  void startCones(std::uint32_t v, double offset);
  void startConesOfFan(std::uint32_t v, double offset);
  void startConesBetween(std::uint32_t v, double offset, std::size_t from, std::size_t to,
                         const Vector2* right, const Vector2* left);
  void startCone(std::uint32_t v, double offset, const FastMarchingCorner& corner,
                 const Vector2& turn, const Vector2& right_ray, const Vector2& left_ray);
  void follow();
  void enterAll(Window& window);
  bool enter(Window& window, std::uint32_t beyond);
  bool split(Window& window, std::uint32_t beyond, const Vector2& place, double from_right,
             double from_left);
  bool goesOn(Window& window) const;
  void queue(const Window& window);
  bool isFirstOfItsKind(const Window& window);
  bool isBestSomewhere(Window& window);
  void offer(std::uint32_t v, const Window& window, const Vector2& place);
  void offerAlong(std::uint32_t from, std::uint32_t v, double distance);
  void take(std::uint32_t v, float distance, std::uint32_t start);
  double gap(std::uint32_t v) const
  {
    if (scope_.gaps != nullptr) {
      return scope_.gaps[v];
    }
    const double at = scope_.at(mesh_.position(v));
    return std::max({0.0, scope_.low - at, at - scope_.high});
  }
  bool canReach(std::uint32_t a, std::uint32_t b, double length, double distance) const;

  double known(std::uint32_t v) const { return distanceOf(labels_[v]); }
  double squaredLength(std::uint32_t a, std::uint32_t b) const
  {
    const Vector3 side = between(mesh_.position(a), mesh_.position(b));
    return dot(side, side);
  }

  void prefetch() const;
  /// Calls visit(v) for each, while the memory of those that follow is fetched.
  template <class Visit>
  void forEachFetched(ArrayView<std::uint32_t> vertices, const Visit& visit) const
  {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (i + LATEST < vertices.size()) {
        prefetchVertex(vertices[i + LATEST]);
      }
      if (i + LATER < vertices.size()) {
        mesh_.prefetchCorners(vertices[i + LATER]);
      }
      if (i + SOON < vertices.size()) {
        prefetchAround(vertices[i + SOON]);
      }
      visit(vertices[i]);
    }
  }
  [[gnu::always_inline]] void prefetchVertex(std::uint32_t v) const
  {
    mesh_.prefetchRow(v);
    mesh_.prefetchVertex(v);
  }
  [[gnu::always_inline]] void prefetchAround(std::uint32_t v) const
  {
    for (const FastMarchingCorner& corner : mesh_.corners(v)) {
      prefetchVertex(corner.a);
      __builtin_prefetch(&labels_[corner.a]);
    }
  }

  /// How many vertices ahead memory is asked for, which is read in this order.
  static constexpr std::size_t LATEST = 12, LATER = 8, SOON = 4;

  const FastMarchingMesh& mesh_;
  double max_distance_;
  ArrayView<std::uint8_t> lethal_;
  WindowScope scope_;
  bool is_all_in_scope_ = true;
  bool is_starting_ = false;  // no vertex is left yet: those that are reached are queued afterwards
  LargeArray<WindowLabel> labels_;
  std::vector<std::uint32_t> reached_;  // whose labels are not NO_LABEL
  DistanceQueue queue_;
  std::vector<Window> windows_;  // those in the queue, and free places
  std::vector<std::uint32_t> free_;
  std::unordered_set<std::uint64_t> seen_;
  std::unordered_map<std::uint64_t, std::vector<PassedWindow>> passed_;  // per edge

  // scratch
  std::vector<Sector> sectors_;
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> beyond_;
  std::vector<Window> next_;
};

}  // namespace mesh_map
