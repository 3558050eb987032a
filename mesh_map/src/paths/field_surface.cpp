#include "paths/field_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "bvh/closest/triangle_point.h"

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
  return distance(from_a, share * side);
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
  const MeshView& mesh = mesh_->mesh;
  const double off =
      TrianglePoint(mesh.vertex(v[0]), mesh.vertex(v[1]), mesh.vertex(v[2]), position.data())
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

double FieldSurface::meanSlowness(std::uint32_t face) const
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
    const auto [beta, gamma] = barycentricWeights(to_b, to_c, cross(to_b, to_c), here);
    // equation (4) of the paper
    result = (1.0 - beta - gamma) * slowness(corner(face, 0)) + beta * slowness(corner(face, 1)) +
             gamma * slowness(corner(face, 2));
  }
  return std::isfinite(result) ? std::max(0.0, result) : meanSlowness(face);
}

namespace {

/// Nearer to the end of an edge than this part of it, one is at the end.
constexpr double AT_END = 1e-9;

/// Slowness that varies by more within two neighboring faces is not taken as the same.
constexpr double SAME_SLOWNESS = 1.5;

/// Where the shortest way from a point at (x, y) crosses a base that runs from the origin along the
/// x axis, and the potential there.
struct Crossing
{
  double share, value;
};

/// Unfolded beyond the base lies the point that has the distances of the labels u and v from both
/// of its ends, and the shortest way goes straight there. Without such a point (a share that is
/// NaN), one end is better than all in between.
Crossing roundCrossing(double u, double v, double base, double x, double y)
{
  const double along = 0.5 * (base + (u - v) * (u + v) / base);
  const double square = (u - along) * (u + along), beyond = std::sqrt(square), height = y + beyond;
  const double share = (x * beyond + along * y) / (height * base);
  const double gap = share * base - along;
  return {share, std::sqrt(gap * gap + square)};
}

/// The same where slowness changes much: the potential is linear on the base, and the way refracted
/// by the law of Snell: along the base, the gradient is `slope`.
Crossing straightCrossing(double u, double v, double base, double x, double y, double slowness)
{
  const double slope = (v - u) / base, sine = slope / slowness;
  const double crossing = x - sine * y / std::sqrt((1.0 - sine) * (1.0 + sine));
  return {crossing / base, u + slope * crossing};
}

}  // namespace

/// Across an edge, if there is a face from which the front may have come.
template <class Sink>
void FieldSurface::edgeOffer(std::uint32_t face, std::size_t k, const FieldPlace& from,
                             double slowness_here, const Sink& sink) const
{
  const std::uint32_t a = corner(face, k), b = corner(face, (k + 1) % 3);
  FieldOffer offer;
  offer.to.kind = FieldPlace::EDGE;
  offer.to.face = offer.face = face;
  offer.to.a = std::min(a, b);
  offer.to.b = std::max(a, b);
  offer.sure = false;
  double low = slowness(a), high = low;
  widen(face, low, high);
  bool has_other = false;
  forFacesAt(offer.to, [&](std::uint32_t other) {
    if (!isSameFace(other, face) && mayEnter(other)) {
      has_other = true;
      widen(other, low, high);
    }
  });
  const Vector3 at_a = position(a), side = position(b) - at_a, gap = from.position - at_a;
  const double length = norm(side);
  const double slow = 0.5 * (slowness(a) + slowness(b));
  if (!has_other || !(slow * length > 0.0)) {
    return;
  }
  const double x = dot(gap, side) / length, y = norm(cross(gap, side)) / length;
  const Crossing crossing =
      high <= SAME_SLOWNESS * low
          ? roundCrossing(label(a), label(b), slow * length, slow * x, slow * y)
          : straightCrossing(label(a), label(b), length, x, y, 0.5 * (slow + slowness_here));
  const double share = crossing.share;
  if (!(share > AT_END && share < 1.0 - AT_END)) {
    return;
  }
  offer.to.position = at_a + share * side;
  const double slowness_there = slowness(a) + share * (slowness(b) - slowness(a));
  offer.step = 0.5 * (slowness_here + slowness_there) * distance(from.position, offer.to.position);
  offer.value = crossing.value;
  sink(offer);
}

template <class Sink>
void FieldSurface::offersIn(std::uint32_t face, const FieldPlace& from, const Sink& sink) const
{
  FieldOffer offer;
  offer.face = face;
  offer.sure = true;
  const double slowness_here = slownessAt(from, face);
  const bool may_cross = isSameFace(face, from.own) || isFaceOpen(face);
  const bool may_follow = isOpenAt(from);
  if (isGoalIn(face) && (may_cross || mayEnter(face))) {
    offer.to = goal_;
    offer.step =
        0.5 * (slowness_here + goalSlowness(face)) * distance(from.position, goal_.position);
    offer.value = 0.0;
    sink(offer);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t v = corner(face, k);
    const bool is_end = v == from.a || v == from.b;
    if (isReached(v) && !(from.kind == FieldPlace::VERTEX && is_end) &&
        (may_cross || (may_follow && (from.kind == FieldPlace::VERTEX || is_end)))) {
      offer.to.kind = FieldPlace::VERTEX;
      offer.to.face = face;
      offer.to.a = v;
      offer.to.b = NO_INDEX;
      offer.to.position = position(v);
      offer.step = 0.5 * (slowness_here + slowness(v)) * distance(from.position, offer.to.position);
      offer.value = label(v);
      sink(offer);
    }
  }
  for (std::size_t k = 0; may_cross && k < 3; ++k) {
    const std::uint32_t a = corner(face, k), b = corner(face, (k + 1) % 3);
    const bool has_a = a == from.a || a == from.b, has_b = b == from.a || b == from.b;
    const bool is_on = from.kind == FieldPlace::EDGE ? has_a && has_b : has_a || has_b;
    if (a != b && !is_on && isReached(a) && isReached(b)) {
      edgeOffer(face, k, from, slowness_here, sink);
    }
  }
}

void FieldSurface::collectOffers(const FieldPlace& from, std::vector<FieldOffer>& offers) const
{
  offers.clear();
  forFacesAt(from, [&](std::uint32_t face) {
    offersIn(face, from, [&offers](const FieldOffer& offer) { offers.push_back(offer); });
  });
}

double FieldSurface::firstValue(const FieldPlace& place) const
{
  if (isSure(place)) {
    return place.kind == FieldPlace::GOAL ? 0.0 : label(place.a);
  }
  double least = std::numeric_limits<double>::infinity();
  forFacesAt(place, [&](std::uint32_t face) {
    offersIn(face, place,
             [&least](const FieldOffer& offer) { least = std::min(least, offer.total()); });
  });
  return least;
}

/// The best offer from a place; nullptr if there is none. Valid until the next call.
const FieldOffer* FieldSurface::nextOffer(const FieldPlace& place) const
{
  collectOffers(place, scratch_);
  return best(
      scratch_, [](const FieldOffer&) { return true; },
      [this](const FieldPlace& to) { return firstValue(to); });
}

double FieldSurface::value(const FieldPlace& place) const
{
  if (isSure(place)) {
    return firstValue(place);
  }
  const FieldOffer* const found = nextOffer(place);
  return found == nullptr ? std::numeric_limits<double>::infinity() : found->total();
}

bool FieldSurface::leadsLower(const FieldPlace& vertex) const
{
  const FieldOffer* const found = nextOffer(vertex);
  return found != nullptr && found->value < label(vertex.a);
}

}  // namespace mesh_map
