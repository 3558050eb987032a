#include "paths/geodesic_strip.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

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
  const double to_left = norm(point - pointOf(mesh, portal.left));
  const double to_right = norm(point - pointOf(mesh, portal.right));
  return to_left <= to_right
             ? portal.at_left + to_left * Unfolding::fromLeft(mesh, portal, point, side)
             : portal.at_right + to_right * Unfolding::fromRight(mesh, portal, point, side);
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

Vector2 Unfolding::fromLeft(const WalkMesh& mesh, const Portal& portal, const Vector3& point,
                            double side)
{
  const Vector2 place = besideEdge(pointOf(mesh, portal.left), pointOf(mesh, portal.right), point);
  return turned(portal.along, unit({place[0], side * place[1]}));
}

Vector2 Unfolding::fromRight(const WalkMesh& mesh, const Portal& portal, const Vector3& point,
                             double side)
{
  const Vector2 place = besideEdge(pointOf(mesh, portal.right), pointOf(mesh, portal.left), point);
  return turned(portal.along, unit({-place[0], side * place[1]}));
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
  portals.push_back({first[0], first[1], {0.0, 0.0}, {length, 0.0}, {1.0, 0.0}});
  from = placed(mesh, portals[0], start, -1.0);
  for (std::size_t i = 1; i < strip.edges.size(); ++i) {
    Portal next = portals.back();
    const std::uint32_t apex = apexOf(mesh, strip.faces[i], strip.edges[i - 1]);
    const auto ends = endsOf(mesh, strip.faces[i], strip.edges[i]);
    const Vector3 point = pointOf(mesh, apex);
    const Vector2 place = placed(mesh, next, point, 1.0);
    if (ends[0] == next.left || ends[1] == next.left) {
      next.along = fromLeft(mesh, portals.back(), point, 1.0);
      next.right = apex;
      next.at_right = place;
    } else {
      next.along = -fromRight(mesh, portals.back(), point, 1.0);
      next.left = apex;
      next.at_left = place;
    }
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
    const double left = mesh_map::cross(way, portal.at_left - from);
    const double right = mesh_map::cross(way, portal.at_right - from);
    const Vector2 across = portal.at_right - portal.at_left;
    double share = 0.0;
    if (left > 0.0 && right < 0.0) {
      share = left / (left - right);
    } else if (left > 0.0 || right < 0.0) {  // past one end by rounding
      share = left > 0.0 ? 1.0 : 0.0;
    } else {  // along the line: as near as possible to where it was
      share =
          std::min(1.0, std::max(0.0, dot(last - portal.at_left, across) / dot(across, across)));
    }
    shares.push_back(share);
    last = portal.at_left + share * across;
  }
  return shares;
}

}  // namespace mesh_map
