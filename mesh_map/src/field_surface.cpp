#include "field_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "triangle_point.h"

namespace mesh_map {
namespace {

constexpr double FAR = std::numeric_limits<double>::infinity();

/// Nearer than this part of its face, a point is on an edge or a vertex.
constexpr double ON_EDGE = 1e-9;

/// By this part of face and coordinates, a point may be off its face: 32-bit floats have no more.
constexpr double OFF_FACE = 1e-6;

double distanceToSegment(const Vector3& point, const Vector3& a, const Vector3& b)
{
  const Vector3 side = b - a, from_a = point - a;
  const double square = dot(side, side);
  const double share = square > 0.0 ? std::clamp(dot(from_a, side) / square, 0.0, 1.0) : 0.0;
  return distance(from_a, {share * side[0], share * side[1], share * side[2]});
}

}  // namespace

FieldSurface::FieldSurface(const TraceMesh& mesh, const SurfaceField& field)
    : mesh_(&mesh), field_(&field)
{
  if (hasGoal()) {
    goal_place_ = placeOf(field.goal_face, field.goal, "the goal");
    goal_.kind = FieldPlace::GOAL;
    goal_.face = field.goal_face;
    goal_.position = field.goal;
  }
}

FieldPlace FieldSurface::placeOf(std::uint32_t face, const Vector3& position,
                                 const char* name) const
{
  const std::uint32_t v[3] = {corner(face, 0), corner(face, 1), corner(face, 2)};
  const Vector3 p[3] = {this->position(v[0]), this->position(v[1]), this->position(v[2])};
  const float* const floats = mesh_->mesh.positions.data();
  const double off = TrianglePoint(floats + 3 * std::size_t{v[0]}, floats + 3 * std::size_t{v[1]},
                                   floats + 3 * std::size_t{v[2]}, position.data())
                         .distance();
  double size = 0.0, far = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    size = std::max(size, distance(p[k], p[(k + 1) % 3]));
    far = std::max({far, std::abs(p[k][0]), std::abs(p[k][1]), std::abs(p[k][2])});
  }
  if (!(off <= OFF_FACE * (size + far))) {
    throw std::invalid_argument(std::string(name) + " is not on face " + std::to_string(face) +
                                ", but " + std::to_string(off) + " m from it");
  }
  FieldPlace place;
  place.face = place.own = face;
  place.position = position;
  double nearest = ON_EDGE * size;
  for (std::size_t k = 0; k < 3; ++k) {
    if (distance(position, p[k]) <= nearest) {
      nearest = distance(position, p[k]);
      place.kind = FieldPlace::VERTEX;
      place.a = v[k];
    }
  }
  for (std::size_t k = 0; place.kind != FieldPlace::VERTEX && k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const double gap = distanceToSegment(position, p[k], p[next]);
    if (v[k] != v[next] && gap <= nearest) {
      nearest = gap;
      place.kind = FieldPlace::EDGE;
      place.a = std::min(v[k], v[next]);
      place.b = std::max(v[k], v[next]);
    }
  }
  return place;
}

bool FieldSurface::isOpen(std::uint32_t v) const
{
  return field_->slowness.empty() || std::isfinite(field_->slowness[v]);
}

bool FieldSurface::isReached(std::uint32_t v) const
{
  return label(v) >= 0.0 && std::isfinite(label(v)) && isOpen(v);
}

bool FieldSurface::isFaceReached(std::uint32_t face) const
{
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t v = corner(face, k);
    if (isReached(v) && label(v) <= field_->limit) {
      return true;
    }
  }
  return false;
}

bool FieldSurface::isFaceOpen(std::uint32_t face) const
{
  return isOpen(corner(face, 0)) && isOpen(corner(face, 1)) && isOpen(corner(face, 2));
}

void FieldSurface::widen(std::uint32_t face, double& low, double& high) const
{
  for (std::size_t k = 0; k < 3; ++k) {
    const double slow = slowness(corner(face, k));
    if (std::isfinite(slow)) {
      low = std::min(low, slow);
      high = std::max(high, slow);
    }
  }
}

double FieldSurface::meanOfOpen(std::uint32_t face) const
{
  double sum = 0.0;
  unsigned count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (isOpen(corner(face, k))) {
      sum += slowness(corner(face, k));
      ++count;
    }
  }
  return count > 0 ? sum / count : 1.0;
}

bool FieldSurface::isGoalIn(std::uint32_t face) const
{
  if (!hasGoal() || isSameFace(face, field_->goal_face)) {
    return hasGoal();
  }
  return goal_place_.kind != FieldPlace::FACE && has(face, goal_place_.a) &&
         (goal_place_.kind == FieldPlace::VERTEX || has(face, goal_place_.b));
}

double FieldSurface::slownessAt(const FieldPlace& place, std::uint32_t face) const
{
  if (field_->slowness.empty()) {
    return 1.0;
  }
  double result = FAR;
  if (place.kind == FieldPlace::VERTEX) {
    result = slowness(place.a);
  } else if (place.kind == FieldPlace::EDGE) {
    const double from_a = distance(place.position, position(place.a));
    const double from_b = distance(place.position, position(place.b));
    result = (from_b * slowness(place.a) + from_a * slowness(place.b)) / (from_a + from_b);
  } else {
    const Vector3 a = position(corner(face, 0)), to_b = position(corner(face, 1)) - a,
                  to_c = position(corner(face, 2)) - a, here = place.position - a;
    const Vector3 normal = cross(to_b, to_c);
    const double square = dot(normal, normal);
    const double beta = dot(cross(here, to_c), normal) / square;
    const double gamma = dot(cross(to_b, here), normal) / square;
    result = (1.0 - beta - gamma) * slowness(corner(face, 0)) + beta * slowness(corner(face, 1)) +
             gamma * slowness(corner(face, 2));
  }
  return std::isfinite(result) ? std::max(0.0, result) : meanSlowness(face);
}

}  // namespace mesh_map
