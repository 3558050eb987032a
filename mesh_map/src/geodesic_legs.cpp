#include "geodesic_legs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "geodesic_funnel.h"

namespace mesh_map {
namespace {

double distanceBetween(const Vector3& a, const Vector3& b)
{
  return std::sqrt(dot(b - a, b - a));
}

/// A leg that is straight in its strip.
Leg straightLeg(const WalkMesh& mesh, Strip strip, const Joint& from, const Joint& to)
{
  Leg leg{std::move(strip)};
  const std::vector<std::uint32_t>&faces = leg.strip.faces, &edges = leg.strip.edges;
  if (edges.empty()) {
    leg.length = distanceBetween(from.position, to.position);
    if (from.vertex != NO_INDEX) {
      leg.at_start = rayTo(mesh, faces[0], from.vertex, to.position);
    }
    if (to.vertex != NO_INDEX) {
      leg.at_end = rayTo(mesh, faces[0], to.vertex, from.position);
    }
    return leg;
  }
  const Unfolding unfolded(mesh, leg.strip, from.position, to.position);
  const Vector2 way = unfolded.to - unfolded.from, back = {-way[0], -way[1]};
  leg.length = std::sqrt(dot(way, way));
  if (from.vertex != NO_INDEX) {
    leg.at_start =
        rayAlong(mesh, faces.front(), edges.front(), unfolded.portals.front(), -1.0, way);
  }
  if (to.vertex != NO_INDEX) {
    leg.at_end = rayAlong(mesh, faces.back(), edges.back(), unfolded.portals.back(), 1.0, back);
  }
  return leg;
}

Strip part(const Strip& strip, std::size_t first, std::size_t last)
{
  const auto at = [](const std::vector<std::uint32_t>& values, std::size_t i) {
    return values.begin() + static_cast<std::ptrdiff_t>(i);
  };
  return {{at(strip.faces, first), at(strip.faces, last + 1)},
          {at(strip.edges, first), at(strip.edges, last)}};
}

bool touches(const WalkMesh& mesh, std::uint32_t face, const Joint& joint)
{
  return joint.vertex == NO_INDEX || hasCorner(mesh, face, joint.vertex);
}

}  // namespace

double Legs::length() const
{
  double sum = 0.0;
  for (const Leg& leg : legs) {
    sum += leg.length;
  }
  return sum;
}

Leg fixedLeg(std::uint32_t face, const Vector3& from, const Vector3& to)
{
  return {{{face}, {}}, distanceBetween(from, to), {}, {}};
}

std::optional<Legs> straighten(const WalkMesh& mesh, Strip strip, const Joint& from,
                               const Joint& to)
{
  strip.trim(mesh, from.vertex, to.vertex);
  Legs result;
  if (strip.edges.empty()) {
    if (!touches(mesh, strip.faces[0], from) || !touches(mesh, strip.faces[0], to)) {
      return std::nullopt;
    }
    result.legs.push_back(straightLeg(mesh, std::move(strip), from, to));
    return result;
  }
  const Unfolding unfolded(mesh, strip, from.position, to.position);
  const std::vector<Bend> bends = funnel(unfolded);
  std::size_t first = 0;  // face
  Joint start = from;
  for (std::size_t i = 0; i <= bends.size(); ++i) {
    const bool is_end = i == bends.size();
    const Joint end = is_end ? to : Joint{pointOf(mesh, bends[i].vertex), bends[i].vertex, false};
    const std::size_t last = std::max(first, is_end ? strip.edges.size() : bends[i].first);
    if (!touches(mesh, strip.faces[first], start) || !touches(mesh, strip.faces[last], end)) {
      return std::nullopt;
    }
    Strip piece = part(strip, first, last);
    piece.trim(mesh, start.vertex, end.vertex);
    result.legs.push_back(straightLeg(mesh, std::move(piece), start, end));
    if (!is_end) {
      result.joints.push_back(end);
      first = bends[i].last + 1;
      start = end;
    }
  }
  return result;
}

void traceLeg(const WalkMesh& mesh, const Leg& leg, const Vector3& from, const Vector3& to,
              WalkTrace& trace)
{
  const Unfolding unfolded(mesh, leg.strip, from, to);
  const std::vector<double> shares = unfolded.crossings();
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const Vector3 left = pointOf(mesh, unfolded.portals[i].left);
    const Vector3 right = pointOf(mesh, unfolded.portals[i].right);
    trace.faces.push_back(leg.strip.faces[i]);
    for (std::size_t k = 0; k < 3; ++k) {
      trace.points.push_back(left[k] + shares[i] * (right[k] - left[k]));
    }
  }
  trace.faces.push_back(leg.strip.faces.back());
  trace.points.insert(trace.points.end(), to.begin(), to.end());
}

}  // namespace mesh_map
