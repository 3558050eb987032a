// What a vertex passes on to one that is not its neighbor, but across the opposite edge of one of
// its faces. Where that one has an obtuse corner there, it may be nearer to the obstacle than both
// ends of the edge, and these, which know of it only later, have nothing to tell.

#include <cmath>

#include "distance/obstacles/obstacle_propagation.h"

namespace mesh_map {

/// What does not know of the obstacle yet, with an edge between of which the same is true of at
/// least one end: of two that know, what they have to tell is enough.
void ObstacleDistance::Propagation::findAcross()
{
  across_.clear();
  for (const FastMarchingAcross& across : mesh_.seenAcross(vertex_)) {
    if (isOpen(across.vertex) && !(isKnown(across.a) && isKnown(across.b))) {
      across_.push_back(across);
    }
  }
}

/// Offers what is across the edge from the node `before` to the node k, both unfolded into the
/// plane, counterclockwise. `is_past`: the direction to `before` is already past the obstacle.
void ObstacleDistance::Propagation::offerAcross(std::size_t before, Vector2 before_place,
                                                std::size_t k, Vector2 place, bool is_past)
{
  const std::uint32_t a = fan_.nodes()[before].vertex, b = fan_.nodes()[k].vertex;
  for (const FastMarchingAcross& across : across_) {
    const bool is_here = (across.a == a && across.b == b) || (across.a == b && across.b == a);
    const std::uint32_t v = across.vertex;
    Vector2 seen;
    if (!is_here ||
        !placeBeyond(before_place, place, squaredLength(a, v), squaredLength(b, v), seen)) {
      continue;
    }
    // Where does the way cross the edge? Not at all where the obstacle lies beyond it, too.
    const Vector2 nearest = nearestOnSegment(piece_.a, piece_.b, seen);
    const Vector2 edge = place - before_place;
    const double from_nearest = cross(before_place - nearest, edge);
    const double from_seen = cross(seen - before_place, edge);
    if (!(from_nearest > 0.0 && from_seen > 0.0)) {
      continue;
    }
    const double t = from_nearest / (from_nearest + from_seen);
    const Vector2 away = seen - nearest, to_a = before_place - nearest, to_b = place - nearest;
    const double squared = dot(away, away);
    if (squared >= dot(to_a, to_a) && squared >= dot(to_b, to_b)) {
      continue;  // both ends will know before it, and tell
    }
    const Vector2 crossing = nearest + t * away;
    const double along = dot(crossing - before_place, edge) / dot(edge, edge);
    const bool bends_here = is_past && cross(nearest, crossing) < 0.0;
    if (!(along >= 0.0 && along <= 1.0) || bends_here || hiding(crossing, nearest) != nullptr) {
      continue;
    }
    double length = piece_.offset + std::sqrt(squared);
    length = atLeastAcross(length, before, before_place, seen);
    length = atLeastAcross(length, k, place, seen);
    const auto distance = static_cast<float>(length);
    // Only to what is farther: see the order in which distances follow from each other.
    if (distance >= above(distance_) && isBetter(distance, v, b, a)) {
      // As seen from there: the x axis points to b, the y axis to where a is.
      const Vector2 axis = place - seen, u = 1.0 / norm(axis) * axis;
      const auto asSeen = [&](Vector2 p) { return Vector2{dot(p - seen, u), cross(u, p - seen)}; };
      take(v, distance, sourceOf(piece_.offset, asSeen(piece_.a), asSeen(piece_.b), b, a));
    }
  }
}

/// A lethal vertex with what it knows: itself, and the edges from it to other lethal ones.
void ObstacleDistance::Propagation::passAcrossFromLethal()
{
  findAcross();
  if (across_.empty()) {
    return;
  }
  fan_.gather(mesh_, vertex_);
  const auto& nodes = fan_.nodes();
  for (const FastMarchingAcross& across : across_) {
    // What has a lethal neighbor there knows of the edge to that one (see seed()).
    if (owner_.lethal_[across.a] != 0 || owner_.lethal_[across.b] != 0) {
      continue;
    }
    const std::size_t a = fan_.find(across.a), b = fan_.find(across.b);
    const VertexFan::Turn by = VertexFan::turn(nodes[a], nodes[b]);
    for (const bool from_a : {true, false}) {
      const std::size_t before = from_a ? a : b, k = from_a ? b : a;
      const Vector2 before_place{nodes[before].length, 0.0};
      const Vector2 place{nodes[k].length * by.cosine, nodes[k].length * by.sine};
      piece_ = {};
      bounds_.clear();
      bounds_.push_back({{1.0, 0.0}, nodes[before].length, {}});
      // The walk goes away from there, so mirrored; the way must not leave the fan in between.
      fan_.walk(before, k, false, [&](const FanStep& step) {
        const VertexFan::Node& node = nodes[step.node];
        if (step.direction[1] < 0.0) {
          return false;
        }
        const Vector2 direction{step.direction[0], -step.direction[1]};
        if (owner_.lethal_[node.vertex] != 0) {
          piece_.b = {node.length * direction[0], node.length * direction[1]};
          return false;
        }
        bounds_.push_back({direction, node.length, {}});
        return true;
      });
      offerAcross(before, before_place, k, place, true);
    }
  }
}

/// The distance, or what follows from that of this vertex and the node k where that is more.
double ObstacleDistance::Propagation::atLeastAcross(double distance, std::size_t k, Vector2 place,
                                                    Vector2 seen) const
{
  const VertexFan::Node& node = fan_.nodes()[k];
  if (!isKnown(node.vertex) || !(node.length > 0.0)) {
    return distance;
  }
  const double least =
      leastDistance(distance_, owner_.distance_[node.vertex], node.length,
                    dot(seen, place) / node.length, std::abs(cross(seen, place)) / node.length);
  return least > distance + SHORTER_THAN_KNOWN * std::sqrt(dot(seen, seen)) ? least : distance;
}

}  // namespace mesh_map
