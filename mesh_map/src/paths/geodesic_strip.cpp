#include "paths/geodesic_strip.h"

#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace mesh_map {
namespace {

/// a turned by the angle of b (and scaled by its length).
Vector2 turned(const Vector2& a, const Vector2& b)
{
  return {a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]};
}

Vector2 unit(const Vector2& a)
{
  const double length = norm(a);
  return length > 0.0 ? a / length : Vector2{};
}

/// Beside a portal, from where its nearer end is.
Vector2 placed(const WalkMesh& mesh, const Portal& portal, const Vector3& point, double side)
{
  const std::array<double, 2> away = {norm(point - pointOf(mesh, portal.ends[0])),
                                      norm(point - pointOf(mesh, portal.ends[1]))};
  const std::size_t end = away[0] <= away[1] ? 0 : 1;
  return portal.at[end] + away[end] * Unfolding::directionFrom(mesh, portal, end, point, side);
}

}  // namespace

void Strip::cross(std::uint32_t edge, std::uint32_t face)
{
  if (!edges.empty() && edges.back() == edge) {
    edges.pop_back();
    faces.pop_back();
    if (faces.back() == face) {
      return;
    }
  }
  edges.push_back(edge);
  faces.push_back(face);
}

Strip Strip::part(std::size_t first, std::size_t last) const
{
  return {{faces.data() + first, faces.data() + last + 1},
          {edges.data() + first, edges.data() + last}};
}

void Strip::trim(const WalkMesh& mesh, std::uint32_t at_start, std::uint32_t at_end)
{
  const auto leadsAround = [&](std::size_t i, std::uint32_t vertex) {
    const auto ends = endsOf(mesh, faces[i], edges[i]);
    return ends[0] == vertex || ends[1] == vertex;
  };
  std::size_t begin = 0, end = edges.size();
  while (begin < end && leadsAround(begin, at_start)) {
    ++begin;
  }
  while (begin < end && leadsAround(end - 1, at_end)) {
    --end;
  }
  *this = part(begin, end);
}

std::size_t sideOf(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge)
{
  const std::uint32_t* const edges = mesh.face_edges.data() + 3 * std::size_t{face};
  return edges[0] == edge ? 0 : edges[1] == edge ? 1 : 2;
}

std::uint32_t apexOf(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge)
{
  return cornerOf(mesh, face, (sideOf(mesh, face, edge) + 2) % 3);
}

std::array<std::uint32_t, 2> endsOf(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge)
{
  const std::size_t k = sideOf(mesh, face, edge);
  return {cornerOf(mesh, face, k), cornerOf(mesh, face, (k + 1) % 3)};
}

bool hasCorner(const WalkMesh& mesh, std::uint32_t face, std::uint32_t vertex)
{
  return cornerOf(mesh, face, slotOf(mesh, face, vertex)) == vertex;
}

bool canCross(const WalkMesh& mesh, std::uint32_t face, std::uint32_t edge)
{
  const auto ends = endsOf(mesh, face, edge);
  return pointOf(mesh, ends[0]) != pointOf(mesh, ends[1]);
}

Vector2 besideEdge(const Vector3& a, const Vector3& b, const Vector3& point)
{
  const Vector3 u = b - a, w = point - a;
  const double length = norm(u);
  return {dot(u, w) / length, norm(cross(u, w)) / length};
}

Vector2 Unfolding::directionFrom(const WalkMesh& mesh, const Portal& portal, std::size_t end,
                                 const Vector3& point, double side)
{
  const Vector3 from = pointOf(mesh, portal.ends[end]), to = pointOf(mesh, portal.ends[1 - end]);
  const Vector2 place = besideEdge(from, to, point);
  return turned(portal.along, unit({end == 0 ? place[0] : -place[0], side * place[1]}));
}

Unfolding::Unfolding(const WalkMesh& mesh, const Strip& strip, const Vector3& start,
                     const Vector3& end)
{
  if (strip.edges.empty()) {
    return;
  }
  portals.reserve(strip.edges.size());
  const auto first = endsOf(mesh, strip.faces[0], strip.edges[0]);
  const double length = norm(pointOf(mesh, first[1]) - pointOf(mesh, first[0]));
  portals.push_back({first, {Vector2{0.0, 0.0}, Vector2{length, 0.0}}, {1.0, 0.0}});
  from = placed(mesh, portals[0], start, -1.0);
  for (std::size_t i = 1; i < strip.edges.size(); ++i) {
    Portal next = portals.back();
    const std::uint32_t apex = apexOf(mesh, strip.faces[i], strip.edges[i - 1]);
    const auto ends = endsOf(mesh, strip.faces[i], strip.edges[i]);
    const Vector3 point = pointOf(mesh, apex);
    const std::size_t kept = ends[0] == next.ends[0] || ends[1] == next.ends[0] ? 0 : 1;
    const Vector2 direction = directionFrom(mesh, next, kept, point, 1.0);
    next.at[1 - kept] = placed(mesh, next, point, 1.0);
    next.ends[1 - kept] = apex;
    next.along = kept == 0 ? direction : -direction;
    portals.push_back(next);
  }
  to = placed(mesh, portals.back(), end, 1.0);
}

std::vector<double> Unfolding::crossings() const
{
  std::vector<double> shares;
  shares.reserve(portals.size());
  const Vector2 way = to - from;
  Vector2 last = from;
  for (const Portal& portal : portals) {
    const double left = mesh_map::cross(way, portal.at[0] - from);
    const double right = mesh_map::cross(way, portal.at[1] - from);
    const Vector2 across = portal.at[1] - portal.at[0];
    double share = 0.0;
    if (left > 0.0 && right < 0.0) {
      share = left / (left - right);
    } else if (left > 0.0 || right < 0.0) {  // past one end by rounding
      share = left > 0.0 ? 1.0 : 0.0;
    } else {  // along the line: as near as possible to where it was
      share = std::min(1.0, std::max(0.0, dot(last - portal.at[0], across) / dot(across, across)));
    }
    shares.push_back(share);
    last = portal.at[0] + share * across;
  }
  return shares;
}

namespace {

constexpr double INFINITE = std::numeric_limits<double>::infinity();

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
    for (std::uint32_t i = mesh.edge_faces.offsets[edge]; i < mesh.edge_faces.offsets[edge + 1];
         ++i) {
      const std::uint32_t face = mesh.edge_faces.values[i];
      if (face == here || !choice_.allows(face) || choice_.firstOf(face) != face) {
        continue;
      }
      const CornerSides sides(mesh, face, vertex_);
      const std::uint32_t next = sides.otherEdge(edge);
      if (canCross(mesh, face, next)) {
        reach(next, angle + sides.angle(mesh), edge, face);
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
    const std::size_t end = sides.ends[k] == portal.ends[0] ? 0 : 1;
    const Vector2 back = -Unfolding::directionFrom(mesh, portal, end, center, side);
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
