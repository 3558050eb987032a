#include "paths/walk_face.h"

#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <cmath>

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
  longest_ = std::max({length, norm(w_), norm(side)});
  tolerance_ = NOTHING * longest_;
  has_area_ = twice_area > NO_AREA * longest_ * longest_ && length > 0.0;
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

}  // namespace mesh_map
