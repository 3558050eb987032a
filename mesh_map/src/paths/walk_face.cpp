#include "paths/walk_face.h"

#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace mesh_map {

namespace {

/// Of the longest edge of a face: what is smaller is nothing.
constexpr double NOTHING = 1e-12;

/// Of the square of the longest edge: a smaller area gives no plane.
constexpr double NO_AREA = 1e-14;

/// The unit vector in a face from an edge to the corner opposite, at a right angle to the edge; 0
/// for a face without area.
Vector3 rise(const WalkMesh& mesh, std::uint32_t from, std::uint32_t to, std::uint32_t opposite)
{
  const Vector3 u = difference(position(mesh, to), position(mesh, from));
  const Vector3 w = difference(position(mesh, opposite), position(mesh, from));
  const Vector3 y = cross(cross(u, w), u);
  const double length = norm(y);
  return length > 0.0 ? y / length : Vector3{};
}

}  // namespace

std::size_t slotOf(const WalkMesh& mesh, std::uint32_t face, std::uint32_t vertex)
{
  return cornerOf(mesh, face, 0) == vertex ? 0 : cornerOf(mesh, face, 1) == vertex ? 1 : 2;
}

std::uint32_t faceAcross(const WalkMesh& mesh, std::uint32_t face, std::size_t opposite_slot)
{
  const std::uint32_t edge = mesh.face_edges[3 * std::size_t{face} + (opposite_slot + 1) % 3];
  const std::uint32_t apex = cornerOf(mesh, face, opposite_slot);
  const std::uint32_t from = cornerOf(mesh, face, (opposite_slot + 1) % 3);
  const std::uint32_t to = cornerOf(mesh, face, (opposite_slot + 2) % 3);
  const auto apexOf = [&](std::uint32_t other) {
    for (std::size_t k = 0; k < 2; ++k) {
      const std::uint32_t vertex = cornerOf(mesh, other, k);
      if (vertex != from && vertex != to) {
        return vertex;
      }
    }
    return cornerOf(mesh, other, 2);
  };
  std::uint32_t best = NO_INDEX;
  double best_bend = 0.0;
  Vector3 own{};
  const std::uint32_t begin = mesh.edge_faces.offsets[edge],
                      end = mesh.edge_faces.offsets[edge + 1];
  for (std::uint32_t i = begin; i < end; ++i) {
    const std::uint32_t other = mesh.edge_faces.values[i];
    if (other == face || (mesh.face_flags[other] & FACE_DUPLICATE) != 0 || apexOf(other) == apex) {
      continue;
    }
    if (end - begin == 2) {
      return other;
    }
    own = best == NO_INDEX ? rise(mesh, from, to, apex) : own;
    const Vector3 theirs = rise(mesh, from, to, apexOf(other));
    // -1 straight on, 1 back; without area, only where there is nothing else
    const double bend = theirs == Vector3{} ? 2.0 : dot(own, theirs);
    if (best == NO_INDEX || bend < best_bend) {
      best = other;
      best_bend = bend;
    }
  }
  return best;
}

FlatFace::FlatFace(const WalkMesh& mesh, std::uint32_t face, std::size_t first, bool reversed)
    : face_(face), slots_{first, (first + (reversed ? 2 : 1)) % 3, (first + (reversed ? 1 : 2)) % 3}
{
  for (std::size_t k = 0; k < 3; ++k) {
    vertices_[k] = cornerOf(mesh, face, slots_[k]);
  }
  const float* const a = position(mesh, vertices_[0]);
  origin_ = pointOf(a);
  u_ = difference(position(mesh, vertices_[1]), a);
  w_ = difference(position(mesh, vertices_[2]), a);
  const Vector3 side = w_ - u_, n = cross(u_, w_);
  const double length = norm(u_), twice_area = norm(n);
  const double longest = std::max({length, norm(w_), norm(side)});
  tolerance_ = NOTHING * longest;
  has_area_ = twice_area > NO_AREA * longest * longest && length > 0.0;
  if (length > 0.0) {
    corners_[1] = {length, 0.0};
    corners_[2] = {dot(u_, w_) / length, twice_area / length};
  } else {
    corners_[2] = {0.0, norm(w_)};
  }
  if (has_area_) {
    x_axis_ = u_ / length;
    normal_ = n / twice_area;
    y_axis_ = cross(normal_, x_axis_);
  }
}

FlatFace FlatFace::along(const WalkMesh& mesh, std::uint32_t face, std::uint32_t from,
                         std::uint32_t to)
{
  const std::size_t first = slotOf(mesh, face, from);
  return FlatFace(mesh, face, first, cornerOf(mesh, face, (first + 1) % 3) != to);
}

std::array<double, 3> FlatFace::barycentric(const Vector2& point) const
{
  const auto unit = [](double value) { return value > 0.0 ? std::min(value, 1.0) : 0.0; };
  const double gamma = corners_[2][1] > 0.0 ? unit(point[1] / corners_[2][1]) : 0.0;
  const double beta =
      corners_[1][0] > 0.0
          ? std::min(unit((point[0] - gamma * corners_[2][0]) / corners_[1][0]), 1.0 - gamma)
          : 0.0;
  std::array<double, 3> weights;
  weights[slots_[0]] = 1.0 - gamma - beta;
  weights[slots_[1]] = beta;
  weights[slots_[2]] = gamma;
  return weights;
}

Vector2 FlatFace::point(const std::array<double, 3>& barycentric) const
{
  const double beta = barycentric[slots_[1]], gamma = barycentric[slots_[2]];
  return {beta * corners_[1][0] + gamma * corners_[2][0], gamma * corners_[2][1]};
}

FaceExit exitOf(const FlatFace& face, const Vector2& point, const Vector2& direction)
{
  // side: how far to the left of the ray the corner is; ahead: how far along it
  std::array<double, 3> side, ahead;
  std::size_t nearest = 3, here = 3, closest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector2 gap = face.corner(k) - point;
    side[k] = cross(direction, gap);
    ahead[k] = dot(direction, gap);
    if (std::abs(side[k]) <= face.tolerance()) {
      if (ahead[k] > face.tolerance()) {
        nearest = nearest == 3 || ahead[k] < ahead[nearest] ? k : nearest;
      } else if (ahead[k] >= -face.tolerance()) {
        here = k;
      }
    }
    closest = std::abs(side[k]) < std::abs(side[closest]) ? k : closest;
  }
  if (nearest != 3) {
    return {FaceExit::CORNER, nearest, ahead[nearest]};
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const bool beside = here == 3 || (k != here && next != here);
    if (beside && side[k] < 0.0 && side[next] > 0.0) {
      const double share = side[k] / (side[k] - side[next]);
      const double distance = ahead[k] + share * (ahead[next] - ahead[k]);
      return {FaceExit::EDGE, k, std::max(0.0, distance), share};
    }
  }
  if (here == 3 && ahead[closest] > 0.0) {  // out of the face by rounding
    return {FaceExit::CORNER, closest, ahead[closest]};
  }
  return {FaceExit::TURN, here == 3 ? closest : here, 0.0};
}

namespace {

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
  return dot(u, u) == 0.0 || dot(w, w) == 0.0 ? PI / 2.0 : angleBetween(u, w);
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
