#include <algorithm>
#include <cmath>
#include <vector>

#include "walk_face.h"

namespace mesh_map {
namespace {

constexpr double PI = 3.14159265358979323846;

/// Radians that are nothing.
constexpr double NO_ANGLE = 1e-9;

/// A face at a vertex: the vertices on its right and its left, and the angle between them.
struct Sector
{
  std::uint32_t face, right, left;
  double angle;
};

/// The angle of a face at a vertex. Where an edge there has no length, that of a face in which it
/// is very short: faces at both ends of such an edge then go round together.
double angleAt(const WalkMesh& mesh, std::uint32_t vertex, std::uint32_t right, std::uint32_t left)
{
  const Vector3 u = difference(position(mesh, right), position(mesh, vertex));
  const Vector3 w = difference(position(mesh, left), position(mesh, vertex));
  if (dot(u, u) == 0.0 || dot(w, w) == 0.0) {
    return PI / 2.0;
  }
  const Vector3 n = cross(u, w);
  return std::atan2(std::sqrt(dot(n, n)), dot(u, w));
}

/// The faces around a vertex to one side of a face, as far as they go.
struct Fan
{
  std::vector<Sector> sectors;
  double angle = 0.0;
  bool closed = false;  // all the way round
  WalkEnd end = WalkEnd::BORDER;
};

Fan fanAround(const WalkMesh& mesh, std::uint32_t vertex, const Sector& start, bool to_left,
              ArrayView<std::uint8_t> mask)
{
  Fan fan;
  Sector at = start;
  // Where more than two faces meet in an edge, the way round may never come back to the start: it
  // then meets this one again, which is moved up ever more rarely (R. Brent's way to find a cycle).
  std::uint32_t met = NO_INDEX;
  std::size_t next_move = 1;
  while (true) {
    const std::uint32_t beyond = to_left ? at.right : at.left;
    const std::uint32_t shared = to_left ? at.left : at.right;
    const std::uint32_t next = faceAcross(mesh, at.face, slotOf(mesh, at.face, beyond));
    fan.closed = next == start.face;
    if (next == NO_INDEX || next == met || fan.closed) {
      return fan;
    }
    if (!mask.empty() && mask[next] == 0) {
      fan.end = WalkEnd::BLOCKED;
      return fan;
    }
    const std::size_t slot = 3 - slotOf(mesh, next, vertex) - slotOf(mesh, next, shared);
    const std::uint32_t other = cornerOf(mesh, next, slot);
    at = to_left ? Sector{next, shared, other, 0.0} : Sector{next, other, shared, 0.0};
    at.angle = angleAt(mesh, vertex, at.right, at.left);
    fan.sectors.push_back(at);
    fan.angle += at.angle;
    if (fan.sectors.size() == next_move) {
      met = next;
      next_move *= 2;
    }
  }
}

VertexTurn inSector(const Sector& sector, double angle)
{
  return {WalkEnd::ARRIVED, sector.face, sector.right,
          std::min(sector.angle, std::max(0.0, angle))};
}

/// Whether a face has no area at the vertex: its sides run the same way, or opposite ways.
bool isFlat(const Sector& sector)
{
  return sector.angle <= NO_ANGLE || sector.angle >= PI - NO_ANGLE;
}

/// So far around the vertex from the side of the start. A direction along a side of a face without
/// area is in the face beside it: there is nothing to walk on in the other one.
VertexTurn inFan(const Fan& fan, const Sector& start, double angle, bool to_left)
{
  const Sector* last = isFlat(start) ? nullptr : &start;
  double behind_last = 0.0;
  const auto endOfLast = [&]() -> VertexTurn {
    if (last == nullptr || behind_last > NO_ANGLE) {
      return {fan.end};
    }
    return inSector(*last, to_left ? last->angle : 0.0);
  };
  for (const Sector& sector : fan.sectors) {
    const bool at_begin = angle <= NO_ANGLE, at_end = angle >= sector.angle - NO_ANGLE;
    if (angle <= sector.angle + NO_ANGLE) {
      if (!isFlat(sector) || (!at_begin && !at_end)) {
        return inSector(sector, to_left ? angle : sector.angle - angle);
      }
      if (at_begin && last != nullptr && behind_last <= NO_ANGLE) {
        return endOfLast();
      }
    }
    angle -= sector.angle;
    behind_last += sector.angle;
    if (!isFlat(sector)) {
      last = &sector;
      behind_last = 0.0;
    }
  }
  return endOfLast();
}

/// After coming through the start at an angle `back` to its right side.
VertexTurn straightOn(const WalkMesh& mesh, std::uint32_t vertex, const Sector& start, double back,
                      ArrayView<std::uint8_t> mask)
{
  const Fan left = fanAround(mesh, vertex, start, true, mask);
  const double on_left = start.angle - back;
  if (left.closed) {
    const double half = (start.angle + left.angle) / 2.0;
    if (half < on_left) {
      return inSector(start, back + half);
    }
    if (half - on_left > left.angle) {
      return inSector(start, back - half);
    }
    return inFan(left, start, half - on_left, true);
  }
  if (on_left + left.angle >= PI - NO_ANGLE) {
    return inFan(left, start, PI - on_left, true);
  }
  const Fan right = fanAround(mesh, vertex, start, false, mask);
  if (back + right.angle >= PI - NO_ANGLE) {
    return inFan(right, start, PI - back, false);
  }
  return {left.end == WalkEnd::BLOCKED ? left.end : right.end};
}

/// From within the vertex, in a direction out of the start: `ahead` is its angle to the right side
/// of the start, more than that of the start.
VertexTurn toTheSide(const WalkMesh& mesh, std::uint32_t vertex, const Sector& start, double ahead,
                     ArrayView<std::uint8_t> mask)
{
  const double over_left = ahead - start.angle, over_right = 2.0 * PI - ahead;
  WalkEnd end = WalkEnd::BORDER;
  for (const bool to_left : {over_left <= over_right, over_left > over_right}) {
    const Fan fan = fanAround(mesh, vertex, start, to_left, mask);
    double angle = to_left ? over_left : over_right;
    if (fan.closed) {
      angle *= fan.angle / (2.0 * PI - start.angle);
    }
    if (angle <= fan.angle + NO_ANGLE && !fan.sectors.empty()) {
      return inFan(fan, start, angle, to_left);
    }
    end = fan.end == WalkEnd::BLOCKED ? fan.end : end;
  }
  return {end};
}

}  // namespace

VertexTurn turnAt(const WalkMesh& mesh, const FlatFace& face, std::size_t k,
                  const Vector2& direction, ArrayView<std::uint8_t> mask)
{
  const std::size_t right = (k + 1) % 3, left = (k + 2) % 3;
  const std::uint32_t vertex = face.vertex(k);
  const Sector start{face.face(), face.vertex(right), face.vertex(left),
                     angleAt(mesh, vertex, face.vertex(right), face.vertex(left))};
  const Vector2 side = face.corner(right) - face.corner(k);
  const double ahead = std::atan2(cross(side, direction), dot(side, direction));  // -PI to PI
  const double back = ahead > 0.0 ? ahead - PI : ahead + PI;
  if (back >= -NO_ANGLE && back <= start.angle + NO_ANGLE) {
    return straightOn(mesh, vertex, start, std::min(start.angle, std::max(0.0, back)), mask);
  }
  return toTheSide(mesh, vertex, start, ahead < 0.0 ? ahead + 2.0 * PI : ahead, mask);
}

}  // namespace mesh_map
