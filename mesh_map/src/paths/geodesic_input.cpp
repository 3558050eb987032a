#include "paths/geodesic_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "base/require.h"
#include "bvh/closest/triangle_point.h"

namespace mesh_map {
namespace {

/// Of the longest edge of a face: so far from a corner or an edge is at it.
constexpr double AT = 1e-12;

/// Of the longest edge: so far from its face, a point is not in it.
constexpr double BESIDE = 1e-6;

/// Of the largest coordinate: what is lost by rounding in double precision, and in single.
constexpr double ROUNDING = 1e-15, SINGLE = 1e-6;

/// What lengths at a face are compared with.
struct FaceScale
{
  double longest = 0.0, farthest = 0.0;

  FaceScale(const WalkMesh& mesh, std::uint32_t face)
  {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 a = pointOf(mesh, cornerOf(mesh, face, k));
      longest = std::max(longest, distance(a, pointOf(mesh, cornerOf(mesh, face, (k + 1) % 3))));
      for (const double coordinate : a) {
        farthest = std::max(farthest, std::abs(coordinate));
      }
    }
  }
};

/// The corner of a face that a point is at; NO_INDEX: none.
std::uint32_t cornerAt(const WalkMesh& mesh, std::uint32_t face, const Vector3& point)
{
  const FaceScale scale(mesh, face);
  double nearest = AT * scale.longest + ROUNDING * scale.farthest;
  std::uint32_t found = NO_INDEX;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t corner = cornerOf(mesh, face, k);
    const double away = distance(point, pointOf(mesh, corner));
    if (away <= nearest) {
      nearest = away;
      found = corner;
    }
  }
  return found;
}

/// An edge of both faces that can be crossed.
std::uint32_t commonEdge(const WalkMesh& mesh, std::uint32_t a, std::uint32_t b)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t edge = mesh.face_edges[3 * std::size_t{a} + k];
    if (mesh.face_edges[3 * std::size_t{b} + sideOf(mesh, b, edge)] == edge &&
        canCross(mesh, a, edge)) {
      return edge;
    }
  }
  return NO_INDEX;
}

/// A face that may be entered and has an edge along which a segment runs.
std::uint32_t faceBeside(const FaceChoice& choice, std::uint32_t face, const Vector3& from,
                         const Vector3& to)
{
  const WalkMesh& mesh = choice.mesh;
  const FaceScale scale(mesh, face);
  const double tolerance = AT * scale.longest + ROUNDING * scale.farthest;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t edge = mesh.face_edges[3 * std::size_t{face} + k];
    if (edge == NO_INDEX || !canCross(mesh, face, edge)) {
      continue;
    }
    const Vector3 a = pointOf(mesh, cornerOf(mesh, face, k));
    const Vector3 b = pointOf(mesh, cornerOf(mesh, face, (k + 1) % 3));
    if (besideEdge(a, b, from)[1] > tolerance || besideEdge(a, b, to)[1] > tolerance) {
      continue;
    }
    for (std::uint32_t i = mesh.edge_faces.offsets[edge]; i < mesh.edge_faces.offsets[edge + 1];
         ++i) {
      if (choice.allows(mesh.edge_faces.values[i])) {
        return mesh.edge_faces.values[i];
      }
    }
  }
  return NO_INDEX;
}

std::string beside(std::size_t point, double distance, std::uint32_t face)
{
  std::ostringstream text;
  text << "point " << point << " of the path is " << distance << " m from face " << face
       << ", in which it should lie";
  return text.str();
}

}  // namespace

void checkPath(const WalkMesh& mesh, const WalkTrace& path, ArrayView<std::uint8_t> mask)
{
  require(mask.empty() || mask.size() == mesh.mesh.faceCount(),
          "the mask has to have one value for each face");
  require(path.points.size() % 3 == 0 && path.points.size() / 3 == path.faces.size() + 1,
          "a path has to have one point more than faces");
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    require(std::isfinite(path.points[i]),
            "point " + std::to_string(i / 3) + " of the path is not finite");
  }
  for (std::size_t i = 0; i < path.faces.size(); ++i) {
    const std::uint32_t face = path.faces[i];
    require(face < mesh.mesh.faceCount(), "face " + std::to_string(i) + " of the path is " +
                                              std::to_string(face) + ", but there are only " +
                                              std::to_string(mesh.mesh.faceCount()) + " faces");
    const FaceScale scale(mesh, face);
    for (std::size_t k = i; k < i + 2; ++k) {
      const double distance =
          TrianglePoint(position(mesh, cornerOf(mesh, face, 0)),
                        position(mesh, cornerOf(mesh, face, 1)),
                        position(mesh, cornerOf(mesh, face, 2)), path.points.data() + 3 * k)
              .distance();
      if (!(distance <= BESIDE * scale.longest + SINGLE * scale.farthest)) {
        throw std::invalid_argument(beside(k, distance, face));
      }
    }
  }
}

Stretches stretchesOf(const FaceChoice& choice, const WalkTrace& path)
{
  const WalkMesh& mesh = choice.mesh;
  Stretches result;
  const auto begin = [&](const Vector3& point, std::uint32_t vertex, std::uint32_t face,
                         bool stays) {
    result.joints.push_back({point, vertex});
    result.stretches.push_back({{{face}, {}}, stays});
  };
  for (std::size_t i = 0; i < path.faces.size(); ++i) {
    const Vector3 point = pointAt(path, i), next = pointAt(path, i + 1);
    std::uint32_t face = path.faces[i];
    bool stays = !choice.allows(face);
    if (stays) {
      const std::uint32_t other = faceBeside(choice, face, point, next);
      stays = other == NO_INDEX;
      face = stays ? face : other;
    }
    face = stays ? face : choice.firstOf(face);
    if (i == 0) {
      begin(point, cornerAt(mesh, face, point), face, stays);
      continue;
    }
    Stretch& last = result.stretches.back();
    const std::uint32_t before = last.strip.faces.back();
    if (stays || last.stays) {
      begin(point, NO_INDEX, face, stays);
    } else if (before != face) {
      const std::uint32_t edge = commonEdge(mesh, before, face);
      if (edge != NO_INDEX) {
        last.strip.cross(edge, face);
      } else {
        const std::uint32_t corner = cornerAt(mesh, face, point);
        const bool is_common = corner != NO_INDEX && hasCorner(mesh, before, corner);
        begin(is_common ? pointOf(mesh, corner) : point, is_common ? corner : NO_INDEX, face,
              false);
      }
    }
  }
  const std::size_t count = path.faces.size();
  result.joints.push_back(
      {pointAt(path, count),
       cornerAt(mesh, result.stretches.back().strip.faces.back(), pointAt(path, count))});
  return result;
}

}  // namespace mesh_map
