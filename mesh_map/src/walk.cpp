#include <mesh_map/walk.h>

#include <algorithm>
#include <cmath>

#include "walk_face.h"
#include "walk_start.h"

namespace mesh_map {
namespace {

/// Somebody in a face who goes straight on.
struct Walker
{
  FlatFace face;
  Vector2 point, direction;
};

class StraightWalk
{
 public:
  StraightWalk(const WalkMesh& mesh, const WalkOptions& options, WalkTrace* trace)
      : mesh_(mesh), options_(options), trace_(trace)
  {
  }

  Walk run(Walker walker, double length)
  {
    Walk walk;
    // Faces without area have no plane: what is told then is where the last other one was left.
    Walker told = walker;
    for (std::size_t steps = 0;; ++steps) {
      const FaceExit exit = exitOf(walker.face, walker.point, walker.direction);
      const bool arrives = length - walk.length <= exit.distance;
      if (arrives || steps >= options_.max_steps) {
        const double rest = arrives ? length - walk.length : 0.0;
        walker.point[0] += rest * walker.direction[0];
        walker.point[1] += rest * walker.direction[1];
        walk.length = arrives ? length : walk.length;  // not off by rounding
        walk.end = arrives ? WalkEnd::ARRIVED : WalkEnd::STEPS;
        told = walker.face.hasArea() ? walker : told;
        follow(walker, rest);
        break;
      }
      walk.length += exit.distance;
      walker.point = pointOf(walker, exit);
      told = walker.face.hasArea() ? walker : told;
      follow(walker, exit.distance);
      walk.end = exit.kind == FaceExit::EDGE ? crossEdge(walker, exit) : turn(walker, exit.index);
      if (walk.end != WalkEnd::ARRIVED) {
        break;
      }
    }
    walk.pose.face = told.face.face();
    walk.pose.barycentric = told.face.barycentric(told.point);
    walk.pose.direction = told.face.inSpace(told.direction);
    walk.pose.up = told.face.normal();
    walk.position = told.face.positionOf(walk.pose.barycentric);
    return walk;
  }

 private:
  static Vector2 pointOf(const Walker& walker, const FaceExit& exit)
  {
    const Vector2& corner = walker.face.corner(exit.index);
    if (exit.kind != FaceExit::EDGE) {
      return corner;
    }
    const Vector2 side = walker.face.corner((exit.index + 1) % 3) - corner;
    return {corner[0] + exit.share * side[0], corner[1] + exit.share * side[1]};
  }

  void follow(const Walker& walker, double distance)
  {
    if (trace_ != nullptr && distance > 0.0 && walker.face.hasArea()) {
      const Vector3 point = walker.face.positionOf(walker.face.barycentric(walker.point));
      trace_->points.insert(trace_->points.end(), point.begin(), point.end());
      trace_->faces.push_back(walker.face.face());
    }
  }

  WalkEnd crossEdge(Walker& walker, const FaceExit& exit) const
  {
    const std::size_t i = exit.index, j = (i + 1) % 3, opposite = (i + 2) % 3;
    const FlatFace& face = walker.face;
    const std::uint32_t next = faceAcross(mesh_, face.face(), face.slot(opposite));
    if (next == NO_INDEX) {
      return WalkEnd::BORDER;
    }
    if (!options_.mask.empty() && options_.mask[next] == 0) {
      return WalkEnd::BLOCKED;
    }
    const Vector2 side = face.corner(i) - face.corner(j);
    const double length = std::hypot(side[0], side[1]);
    const Vector2 unit{side[0] / length, side[1] / length};
    const Vector2 direction{dot(walker.direction, unit),
                            std::max(0.0, cross(unit, walker.direction))};
    const double size = std::hypot(direction[0], direction[1]);
    const FlatFace beyond = FlatFace::along(mesh_, next, face.vertex(j), face.vertex(i));
    walker = {beyond,
              {(1.0 - exit.share) * beyond.corner(1)[0], 0.0},
              {direction[0] / size, direction[1] / size}};
    return WalkEnd::ARRIVED;
  }

  WalkEnd turn(Walker& walker, std::size_t corner) const
  {
    const std::uint32_t vertex = walker.face.vertex(corner);
    const VertexTurn to = turnAt(mesh_, walker.face, corner, walker.direction, options_.mask);
    if (to.end == WalkEnd::ARRIVED) {
      walker = {FlatFace::along(mesh_, to.face, vertex, to.right),
                {0.0, 0.0},
                {std::cos(to.angle), std::sin(to.angle)}};
    }
    return to.end;
  }

  const WalkMesh& mesh_;
  const WalkOptions& options_;
  WalkTrace* trace_;
};

/// Of length 1; 0 if it is 0, not finite, or not along the face.
Vector2 unitAlong(const FlatFace& face, const Vector3& direction)
{
  const double largest =
      std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
  if (!isFinite(direction) || !(largest > 0.0)) {
    return {0.0, 0.0};
  }
  const Vector2 flat =
      face.flat({direction[0] / largest, direction[1] / largest, direction[2] / largest});
  const double size = std::hypot(flat[0], flat[1]);
  return size > 1e-9 ? Vector2{flat[0] / size, flat[1] / size} : Vector2{0.0, 0.0};
}

}  // namespace

Walk walkStraight(const WalkMesh& mesh, const WalkPose& start, double length,
                  const WalkOptions& options, WalkTrace* trace)
{
  checkWalk(mesh, options);
  Walk walk;
  walk.pose = start;
  if (!canStart(mesh, start) || std::isnan(length)) {
    return walk;
  }
  const FlatFace face = startFace(mesh, start);
  Vector2 direction = face.hasArea() ? unitAlong(face, start.direction) : Vector2{0.0, 0.0};
  if (direction == Vector2{0.0, 0.0}) {
    return walk;
  }
  const bool backwards = length < 0.0;
  if (backwards) {
    direction = {-direction[0], -direction[1]};
  }
  beginTrace(trace, face.positionOf(face.barycentric(face.point(start.barycentric))));
  walk = StraightWalk(mesh, options, trace)
             .run({face, face.point(start.barycentric), direction}, std::abs(length));
  for (double& value : walk.pose.direction) {
    value = backwards ? -value : value;
  }
  return walk;
}

}  // namespace mesh_map
