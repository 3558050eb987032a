#include "distance/obstacles/obstacle_propagation.h"

#include <cmath>
#include <limits>
#include <tuple>

namespace mesh_map {
namespace {

/// Ways that bend by less than this (radians) count as straight: it lengthens them by less than
/// what 32-bit floats can tell apart.
constexpr double STRAIGHT = 1e-4;

/// A neighbor that is farther from the obstacle than it looks from here, by this part of the edge
/// to it, does not see the same piece of the obstacle.
constexpr float FARTHER_THAN_SEEN = 0.01f;

/// What looks nearer than the vertex that is looked from, by this part of the edge, would have been
/// known before if it were to be seen from there.
constexpr float MUCH_NEARER = 0.25f;

constexpr std::size_t MAX_BOUNDS = 16;

constexpr std::uint32_t STEPS_PER_CANCEL_CHECK = 4096;

double bucketWidth(double mean_edge, double max_distance)
{
  return std::min(mean_edge / 4.0, std::max(mean_edge / 256.0, max_distance / 4000.0));
}

}  // namespace

ObstacleDistance::Propagation::Propagation(ObstacleDistance& owner, std::uint8_t stamp,
                                           bool sees_outside)
    : owner_(owner),
      mesh_(*owner.mesh_),
      queue_(bucketWidth(mesh_.meanEdge(), owner.max_distance_)),
      stamp_(stamp),
      sees_outside_(sees_outside)
{
}

bool ObstacleDistance::Propagation::run(const std::atomic<bool>* cancel)
{
  DistanceEntry entry;
  for (std::uint32_t steps = 1; queue_.pop(entry); ++steps) {
    prefetch();
    if (entry.distance == owner_.distance_[entry.vertex]) {
      propagate(entry.vertex);
    }
    if (steps % STEPS_PER_CANCEL_CHECK == 0 && cancel != nullptr && cancel->load()) {
      return false;
    }
  }
  return true;
}

void ObstacleDistance::Propagation::prefetch() const
{
  constexpr std::size_t soon = 5, later = 12, latest = 24;
  if (const std::uint32_t v = queue_.peek(latest); v != NO_INDEX) {
    mesh_.prefetchRow(v);
    mesh_.prefetchAcross(v);
    mesh_.prefetchVertex(v);
    __builtin_prefetch(&owner_.distance_[v]);
    __builtin_prefetch(&owner_.source_[v]);
  }
  if (const std::uint32_t v = queue_.peek(later); v != NO_INDEX) {
    mesh_.prefetchCorners(v);
    __builtin_prefetch(mesh_.seenAcross(v).begin());
  }
  if (const std::uint32_t v = queue_.peek(soon); v != NO_INDEX) {
    for (const FastMarchingCorner& corner : mesh_.corners(v)) {
      mesh_.prefetchVertex(corner.a);
      __builtin_prefetch(&owner_.distance_[corner.a]);
      __builtin_prefetch(&owner_.stamps_[corner.a]);
      __builtin_prefetch(&owner_.source_[corner.a]);
    }
    for (const FastMarchingAcross& across : mesh_.seenAcross(v)) {
      __builtin_prefetch(&owner_.distance_[across.vertex]);
      __builtin_prefetch(&owner_.stamps_[across.vertex]);
    }
  }
}

void ObstacleDistance::Propagation::propagate(std::uint32_t vertex)
{
  vertex_ = vertex;
  distance_ = owner_.distance_[vertex];
  if (distance_ == 0.0f) {
    passAcrossFromLethal();
    return;
  }
  if (!hasOpenNeighbor()) {
    return;
  }
  findAcross();
  fan_.gather(mesh_, vertex);
  const auto& nodes = fan_.nodes();
  const Source source = owner_.source_[vertex];
  seen_.assign(nodes.size(), 0);

  const std::size_t axis = fan_.find(source.axis), side = fan_.find(source.side);
  piece_ = {{source.ax, source.ay}, {source.bx, source.by}, source.offset};
  look(axis, side, true);
  piece_.a[1] = -piece_.a[1];
  piece_.b[1] = -piece_.b[1];
  look(axis, side, false);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (seen_[k] == 0 && isOpen(nodes[k].vertex)) {
      offerBent(k);
    }
  }
}

bool ObstacleDistance::Propagation::hasOpenNeighbor() const
{
  for (const FastMarchingCorner& corner : mesh_.corners(vertex_)) {
    if (isOpen(corner.a) || isOpen(corner.b)) {
      return true;
    }
  }
  return false;
}

void ObstacleDistance::Propagation::look(std::size_t axis, std::size_t side, bool toward)
{
  const Vector2 left = cross(piece_.a, piece_.b) > 0.0 ? piece_.b : piece_.a;
  const double straight = STRAIGHT * norm(left);
  // Has the walk come past the direction to the obstacle (but not yet half a turn beyond it)?
  bool is_past = left[1] <= 0.0;
  bounds_.clear();
  Vector2 before{fan_.nodes()[axis].length, 0.0};
  fan_.walk(axis, side, toward, [&](const FanStep& step) {
    const double past = cross(left, step.direction);
    if (is_past && past < -straight) {
      return false;  // the way to what follows goes round the other side, or bends here
    }
    const VertexFan::Node& node = fan_.nodes()[step.node];
    const Vector2 place = node.length * step.direction;
    if (!across_.empty()) {  // in a fan: the node before this one is the last one that was seen
      offerAcross(step.before, before, step.node, place, is_past);
      before = place;
    }
    is_past = past >= 0.0 || (is_past && past >= -straight);
    const Vector2 nearest = nearestOnSegment(piece_.a, piece_.b, place);
    if (isOpen(node.vertex)) {
      const double sideways = cross(nearest, step.direction);
      const bool passes_here = is_past && sideways < 0.0 && sideways < -STRAIGHT * norm(nearest);
      if (!passes_here) {
        const Bound* const bound = hiding(place, nearest);
        if (bound == nullptr) {
          offerSeen(step, place, nearest, piece_);
        } else {
          offerSeen(step, place, bound->piece.a, bound->piece);
        }
      }
    }
    if (bounds_.size() < MAX_BOUNDS) {
      addBound(step, place, nearest);
    }
    return true;
  });
}

/// Where a way passes beyond a bound, seen from here, what it crosses there may be a hole: it has
/// to bend at the bound.
const ObstacleDistance::Propagation::Bound* ObstacleDistance::Propagation::hiding(
    Vector2 place, Vector2 nearest) const
{
  for (const Bound& bound : bounds_) {
    const double to_place = cross(bound.direction, place);
    const double to_nearest = cross(nearest, bound.direction);
    if (to_place > 0.0 && to_nearest > 0.0) {  // the bound is between the two
      const double t = to_nearest / (to_place + to_nearest);
      const Vector2 crossing = nearest + t * (place - nearest);
      if (dot(crossing, bound.direction) > bound.length * (1.0 + STRAIGHT)) {
        return &bound;
      }
    }
  }
  return nullptr;
}

/// Vertices at a border, and such that do not see what is seen from here.
void ObstacleDistance::Propagation::addBound(const FanStep& step, Vector2 place, Vector2 nearest)
{
  const VertexFan::Node& node = fan_.nodes()[step.node];
  const bool is_known = isKnown(node.vertex);
  const bool is_border = !mesh_.isClosed(node.vertex);
  if (!is_known && !is_border) {
    return;
  }
  const Vector2 away = place - nearest;
  const double squared = dot(away, away), distance = owner_.distance_[node.vertex];
  const double farther = distance - piece_.offset - FARTHER_THAN_SEEN * node.length;
  if (is_border || (farther > 0.0 && farther * farther > squared)) {
    const double offset = is_known ? distance : piece_.offset + std::sqrt(squared);
    bounds_.push_back({step.direction, node.length, {place, place, offset}});
  }
}

/// The distance, or what follows from that of this vertex and the one before where that is more.
double ObstacleDistance::Propagation::atLeast(double distance, const FanStep& step) const
{
  const VertexFan::Node &node = fan_.nodes()[step.node], &before = fan_.nodes()[step.before];
  if (!isKnown(before.vertex) || !(before.length > 0.0)) {
    return distance;
  }
  const double x = dot(node.direction, before.direction);
  const double y = std::sqrt(std::max(0.0, 1.0 - x * x));
  const double least = leastDistance(distance_, owner_.distance_[before.vertex], before.length,
                                     node.length * x, node.length * y);
  return least > distance + SHORTER_THAN_KNOWN * node.length ? least : distance;
}

/// The way there leads straight to a piece, or to where it bends; or it bends here.
void ObstacleDistance::Propagation::offerSeen(const FanStep& step, Vector2 place, Vector2 nearest,
                                              const Piece& piece)
{
  const VertexFan::Node& node = fan_.nodes()[step.node];
  const auto straight = static_cast<float>(atLeast(piece.offset + norm(place - nearest), step));
  const float bent = distance_ + static_cast<float>(node.length);
  if ((&piece != &piece_ && straight > bent) ||
      straight < distance_ - MUCH_NEARER * static_cast<float>(node.length)) {
    return;
  }
  const float distance = std::max(above(distance_), std::min(straight, bent));
  const std::uint32_t before = fan_.nodes()[step.before].vertex;
  seen_[step.node] = 1;
  if (isBetter(distance, node.vertex, vertex_, before)) {
    // As seen from there: the x axis points here, the y axis to where the walk comes from.
    const auto asSeen = [&](Vector2 p) {
      return Vector2{-dot(p - place, step.direction), cross(p - place, step.direction)};
    };
    take(node.vertex, distance,
         sourceOf(piece.offset, asSeen(piece.a), asSeen(piece.b), vertex_, before));
  }
}

/// The way to what cannot be seen straight bends here.
void ObstacleDistance::Propagation::offerBent(std::size_t k)
{
  const auto& nodes = fan_.nodes();
  const auto length = static_cast<float>(nodes[k].length);
  const float distance = std::max(above(distance_), distance_ + length);
  const std::size_t next = k + 1 < nodes.size() ? k + 1 : k > 0 ? k - 1 : k;
  const std::uint32_t side = next == k ? vertex_ : nodes[next].vertex;
  if (isBetter(distance, nodes[k].vertex, vertex_, side)) {
    take(nodes[k].vertex, distance, {distance_, length, 0.0f, length, 0.0f, vertex_, side});
  }
}

bool ObstacleDistance::Propagation::isBetter(float distance, std::uint32_t v, std::uint32_t axis,
                                             std::uint32_t side) const
{
  const float known = owner_.distance_[v];
  if (distance != known) {
    return distance < known && distance <= owner_.max_distance_;
  }
  const Source& source = owner_.source_[v];
  return known < std::numeric_limits<float>::infinity() &&
         std::tie(axis, side) < std::tie(source.axis, source.side);
}

void ObstacleDistance::Propagation::take(std::uint32_t v, float distance, const Source& source)
{
  if (distance < owner_.distance_[v]) {
    queue_.push(distance, v);
  }
  owner_.distance_[v] = distance;
  owner_.source_[v] = source;
}

}  // namespace mesh_map
