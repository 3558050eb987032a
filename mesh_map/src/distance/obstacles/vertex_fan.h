#pragma once

#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/packed_position.h"

namespace mesh_map {

/// One step of unfolding: where a point lies in the plane, beyond the line from a to b as seen from
/// the origin, at given squared distances from these.
inline bool placeBeyond(Vector2 a, Vector2 b, double from_a, double from_b, Vector2& result)
{
  const Vector2 side = b - a;
  const double squared = dot(side, side);
  if (!(squared > 0.0)) {
    return false;
  }
  const double along = 0.5 * (from_a + squared - from_b) / squared;
  const double height = std::sqrt(std::max(0.0, from_a / squared - along * along));
  // Counterclockwise from a to b around the origin: beyond is to the right of the side.
  result = {a[0] + along * side[0] + height * side[1], a[1] + along * side[1] - height * side[0]};
  return true;
}

/// A vertex next to the one in the middle, as a walk around the middle comes to it: its direction
/// with all faces passed unfolded into a plane, and the one that it came to before.
struct FanStep
{
  std::size_t node;
  std::size_t before;
  Vector2 direction;  // of length 1
};

/// The vertices next to one, and walks among them from face to face. Owns scratch memory.
class VertexFan
{
 public:
  struct Node
  {
    std::uint32_t vertex;
    Vector3 direction;  // from the middle, of length 1
    double length;
  };
  struct Turn
  {
    double cosine, sine;
  };

  static Node node(const PackedPosition& from, const PackedPosition& to, std::uint32_t vertex)
  {
    const Vector3 side = between(from, to);
    const double length = norm(side);
    return {vertex, (length > 0.0 ? 1.0 / length : 0.0) * side, length};
  }

  /// The angle between two sides; none where one of them is without length.
  static Turn turn(const Node& a, const Node& b)
  {
    const double sine = norm(cross(a.direction, b.direction));
    const double cosine = dot(a.direction, b.direction);
    return {sine + std::abs(cosine) > 0.5 ? cosine : 1.0, sine};
  }

  void gather(const FastMarchingMesh& mesh, std::uint32_t middle);

  const std::vector<Node>& nodes() const { return nodes_; }
  /// Number of the node of a vertex; nodes().size() where it is none.
  std::size_t find(std::uint32_t vertex) const;

  /// Walks from the node `axis`, whose direction is (1, 0), toward `side` (or away from it), with
  /// directions that turn counterclockwise. Calls body(step) for each node it comes to, which
  /// returns whether to go on beyond it. In a fan this is simply one after the other; where more
  /// than two faces meet at an edge, it goes through all of them, and comes to each node on the
  /// shortest way round.
  template <class Body>
  void walk(std::size_t axis, std::size_t side, bool toward, Body&& body)
  {
    if (is_fan_) {
      walkFan(axis, side, toward, body);
    } else {
      walkAny(axis, side, toward, body);
    }
  }

 private:
  struct Arc
  {
    std::size_t from, to;
    double angle;
  };
  struct Place
  {
    double angle;
    std::size_t node, before;
    bool operator>(const Place& other) const
    {
      return angle != other.angle ? angle > other.angle : node > other.node;
    }
  };

  void gatherAny(const FastMarchingMesh& mesh, std::uint32_t middle);

  template <class Body>
  void walkFan(std::size_t axis, std::size_t side, bool toward, Body&& body)
  {
    const std::size_t count = nodes_.size();
    const bool up = ((axis + 1 < count || is_closed_) && side == (axis + 1) % count) == toward;
    FanStep step{axis, axis, {1.0, 0.0}};
    for (std::size_t i = 0; i < turns_.size(); ++i) {
      if (!is_closed_ && (up ? step.node + 1 == count : step.node == 0)) {
        return;
      }
      step.before = step.node;
      step.node = up ? (step.node + 1) % count : (step.node + count - 1) % count;
      const Turn& by = turns_[up ? step.before : step.node];
      step.direction = {step.direction[0] * by.cosine - step.direction[1] * by.sine,
                        step.direction[1] * by.cosine + step.direction[0] * by.sine};
      if (!body(static_cast<const FanStep&>(step))) {
        return;
      }
    }
  }

  template <class Body>
  void walkAny(std::size_t axis, std::size_t side, bool toward, Body&& body)
  {
    startAny(axis, side, toward);
    Place place;
    while (nextAny(place)) {
      if (body(FanStep{place.node, place.before, {std::cos(place.angle), std::sin(place.angle)}})) {
        leaveAny(place);
      }
    }
  }

  void startAny(std::size_t axis, std::size_t side, bool toward);
  bool nextAny(Place& place);
  void leaveAny(const Place& place);

  bool is_fan_ = false, is_closed_ = false;
  std::vector<Node> nodes_;
  std::vector<Turn> turns_;              // in a fan: from each node to the next one
  std::vector<Arc> arcs_;                // elsewhere: faces in both directions, sorted by `from`
  std::vector<std::size_t> arc_starts_;  // rows of arcs_
  std::vector<Place> places_;            // heap
  std::vector<bool> reached_;
};

}  // namespace mesh_map
