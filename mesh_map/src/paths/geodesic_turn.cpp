#include "paths/geodesic_turn.h"

#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace mesh_map {
namespace {

constexpr double INFINITE = std::numeric_limits<double>::infinity();

/// The two edges of a face at one of its corners, and their other ends.
struct CornerSides
{
  std::array<std::uint32_t, 2> edges, ends;

  CornerSides(const WalkMesh& mesh, std::uint32_t face, std::uint32_t corner)
  {
    const std::size_t k = slotOf(mesh, face, corner);
    edges = {mesh.face_edges[3 * std::size_t{face} + k],
             mesh.face_edges[3 * std::size_t{face} + (k + 2) % 3]};
    ends = {cornerOf(mesh, face, (k + 1) % 3), cornerOf(mesh, face, (k + 2) % 3)};
  }
};

/// Dijkstra (1959) on the edges around a vertex, by angle.
class TurnSearch
{
 public:
  TurnSearch(const FaceChoice& choice, std::uint32_t vertex, const CornerDirection& to)
      : choice_(choice), vertex_(vertex), to_(to)
  {
  }

  std::optional<Turn> run(const CornerDirection& from, double limit)
  {
    double best = limit;
    std::uint32_t last = NO_INDEX;
    bool found = false;
    if (from.face == to_.face) {
      const std::size_t k = std::isfinite(from.angles[0]) ? 0 : 1;
      const double angle = std::abs(from.angles[k] - to_.angles[k]);
      found = angle < best;
      best = std::min(best, angle);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      reach(from.edges[k], from.angles[k], NO_INDEX, from.face);
    }
    while (!queue_.empty() && std::get<0>(queue_.top()) < best) {
      const auto [angle, edge] = queue_.top();
      queue_.pop();
      if (angle > steps_.at(edge).angle) {
        continue;
      }
      for (std::size_t k = 0; k < 2; ++k) {
        if (edge == to_.edges[k] && steps_.at(edge).face != to_.face &&
            angle + to_.angles[k] < best) {
          best = angle + to_.angles[k];
          last = edge;
          found = true;
        }
      }
      goOn(edge, angle);
    }
    return found ? std::optional<Turn>(turn(last)) : std::nullopt;
  }

 private:
  /// How an edge was reached: through a face, from an edge before.
  struct Step
  {
    double angle;
    std::uint32_t before, face;
  };
  using Item = std::pair<double, std::uint32_t>;

  void reach(std::uint32_t edge, double angle, std::uint32_t before, std::uint32_t face)
  {
    if (!std::isfinite(angle)) {
      return;
    }
    const auto [place, is_new] = steps_.try_emplace(edge, Step{angle, before, face});
    if (is_new || angle < place->second.angle) {
      place->second = {angle, before, face};
      queue_.push({angle, edge});
    }
  }

  void goOn(std::uint32_t edge, double angle)
  {
    const WalkMesh& mesh = choice_.mesh;
    const std::uint32_t here = steps_.at(edge).face;
    const Vector3 center = pointOf(mesh, vertex_);
    for (std::uint32_t i = mesh.edge_faces.offsets[edge]; i < mesh.edge_faces.offsets[edge + 1];
         ++i) {
      const std::uint32_t face = mesh.edge_faces.values[i];
      if (face == here || !choice_.allows(face) || choice_.firstOf(face) != face) {
        continue;
      }
      const CornerSides sides(mesh, face, vertex_);
      const std::size_t next = sides.edges[0] == edge ? 1 : 0;
      if (canCross(mesh, face, sides.edges[next])) {
        const double corner = angleBetween(pointOf(mesh, sides.ends[0]) - center,
                                           pointOf(mesh, sides.ends[1]) - center);
        reach(sides.edges[next], angle + corner, edge, face);
      }
    }
  }

  Turn turn(std::uint32_t last) const
  {
    Turn turn;
    for (std::uint32_t edge = last; edge != NO_INDEX; edge = steps_.at(edge).before) {
      turn.edges.push_back(edge);
      if (steps_.at(edge).before != NO_INDEX) {
        turn.faces.push_back(steps_.at(edge).face);
      }
    }
    std::reverse(turn.edges.begin(), turn.edges.end());
    std::reverse(turn.faces.begin(), turn.faces.end());
    return turn;
  }

  const FaceChoice& choice_;
  const std::uint32_t vertex_;
  const CornerDirection& to_;
  std::unordered_map<std::uint32_t, Step> steps_;
  std::priority_queue<Item, std::vector<Item>, std::greater<Item>> queue_;
};

}  // namespace

bool FaceChoice::allows(std::uint32_t face) const
{
  return (mask.empty() || mask[face] != 0) && (mesh.face_flags[face] & FACE_DEGENERATE) == 0;
}

std::uint32_t FaceChoice::firstOf(std::uint32_t face) const
{
  if ((mesh.face_flags[face] & FACE_DUPLICATE) == 0) {
    return face;
  }
  const std::uint32_t edge = mesh.face_edges[3 * std::size_t{face}];
  const std::uint32_t* other = mesh.edge_faces.values.data() + mesh.edge_faces.offsets[edge];
  const std::uint32_t apex = apexOf(mesh, face, edge);
  while (*other != face && !(allows(*other) && apexOf(mesh, *other, edge) == apex)) {
    ++other;
  }
  return *other;
}

CornerDirection directionTo(const WalkMesh& mesh, std::uint32_t face, std::uint32_t corner,
                            const Vector3& point)
{
  const CornerSides sides(mesh, face, corner);
  const Vector3 center = pointOf(mesh, corner);
  CornerDirection ray{face, sides.edges, {INFINITE, INFINITE}};
  for (std::size_t k = 0; k < 2; ++k) {
    const Vector3 side = pointOf(mesh, sides.ends[k]) - center;
    if (side != Vector3{}) {
      ray.angles[k] = angleBetween(side, point - center);
    }
  }
  return ray;
}

CornerDirection directionAlong(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge,
                               const Portal& portal, double side, const Vector2& direction)
{
  const std::uint32_t apex = apexOf(mesh, face, edge);
  const Vector3 center = pointOf(mesh, apex);
  const CornerSides sides(mesh, face, apex);
  CornerDirection ray{face, sides.edges, {INFINITE, INFINITE}};
  for (std::size_t k = 0; k < 2; ++k) {
    const Vector2 to_apex = sides.ends[k] == portal.left
                                ? Unfolding::fromLeft(mesh, portal, center, side)
                                : Unfolding::fromRight(mesh, portal, center, side);
    const Vector2 back = -to_apex;
    if (back != Vector2{}) {
      ray.angles[k] = std::atan2(std::abs(cross(back, direction)), dot(back, direction));
    }
  }
  return ray;
}

std::optional<Turn> turnBelow(const FaceChoice& choice, std::uint32_t vertex,
                              const CornerDirection& from, const CornerDirection& to, double limit)
{
  if (from.face == NO_INDEX || to.face == NO_INDEX) {
    return std::nullopt;
  }
  return TurnSearch(choice, vertex, to).run(from, limit);
}

}  // namespace mesh_map
