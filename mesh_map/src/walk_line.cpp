#include <algorithm>
#include <cmath>

#include "walk_face.h"
#include "walk_start.h"

namespace mesh_map {
namespace {

/// How far the start is moved into its face, so that the plane cuts that.
constexpr double INTO_FACE = 1e-9;

/// The cut of a surface with a plane. A vertex is on one side or the other, always the same one, so
/// that each face that the plane enters through an edge, it leaves through another: no rounding can
/// lose the way.
class Cut
{
 public:
  Cut(const WalkMesh& mesh, const FlatFace& face, const Vector2& start, const Vector3& up,
      const std::array<double, 3>& target)
      : mesh_(mesh), origin_(position(mesh, face.vertex(0)))
  {
    start_ = face.inSpace(start);  // from corner 0: small numbers, wherever the mesh is
    const Vector3 way = gap(target) - start_;
    const Vector3 along = ofSizeOne(way);
    normal_ = mesh_map::cross(up, along);
    forward_ = mesh_map::cross(normal_, up);
    const double size = std::sqrt(dot(forward_, forward_));
    if (size > 1e-12 * dot(up, up) * std::sqrt(dot(along, along))) {
      forward_ = {forward_[0] / size, forward_[1] / size, forward_[2] / size};
      goal_ = dot(forward_, way);
    }
  }

  /// How far along the way the target is; 0 if it is just above or below the start.
  double goal() const { return goal_; }

  /// Of a point as it comes from the functions below.
  double progress(const Vector3& point) const { return dot(forward_, point - start_); }
  const Vector3& start() const { return start_; }

  bool isLeft(std::uint32_t vertex) const { return height(vertex) >= 0.0; }

  /// Where the plane cuts an edge with corners on both sides. The same from both faces.
  Vector3 crossing(std::uint32_t a, std::uint32_t b) const
  {
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    const double from = height(low), to = height(high);
    const double share = from / (from - to);
    const Vector3 p = local(low), q = local(high);
    Vector3 result;
    for (std::size_t i = 0; i < 3; ++i) {
      result[i] = p[i] + share * (q[i] - p[i]);
    }
    return result;
  }

  Vector3 local(std::uint32_t vertex) const { return difference(position(mesh_, vertex), origin_); }

  Vector3 inSpace(const Vector3& point) const
  {
    return {origin_[0] + point[0], origin_[1] + point[1], origin_[2] + point[2]};
  }

 private:
  double height(std::uint32_t vertex) const { return dot(normal_, local(vertex) - start_); }

  Vector3 gap(const std::array<double, 3>& point) const
  {
    return {point[0] - origin_[0], point[1] - origin_[1], point[2] - origin_[2]};
  }

  const WalkMesh& mesh_;
  const float* origin_;
  Vector3 start_{}, normal_{}, forward_{};
  double goal_ = 0.0;
};

Vector3 between(const Vector3& a, const Vector3& b, double share)
{
  return {a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])};
}

/// Somebody in a face who goes along the cut.
struct Place
{
  std::uint32_t face;
  bool reversed;          // whether he is on the side from which the corners run clockwise
  Vector3 point;          // relative to the origin of the cut
  std::size_t entry = 3;  // slot of the corner opposite to the edge where he came in
};

/// Where the cut leaves a face.
struct CutExit
{
  std::size_t slot = 3;  // of the corner opposite to the edge; 3: nowhere
  Vector3 point{};
};

/// Of two edges with corners on both sides, the one that was not the entry, or leads on.
CutExit exitOf(const WalkMesh& mesh, const Cut& cut, const Place& place)
{
  CutExit exit;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = cornerOf(mesh, place.face, (k + 1) % 3);
    const std::uint32_t b = cornerOf(mesh, place.face, (k + 2) % 3);
    if (k == place.entry || cut.isLeft(a) == cut.isLeft(b)) {
      continue;
    }
    const Vector3 point = cut.crossing(a, b);
    if (exit.slot == 3 || cut.progress(point) > cut.progress(exit.point)) {
      exit = {k, point};
    }
  }
  return exit;
}

/// Over an edge, on the same side of the surface.
Place across(const WalkMesh& mesh, const Place& place, const CutExit& exit, std::uint32_t next)
{
  const std::uint32_t a = cornerOf(mesh, place.face, (exit.slot + 1) % 3);
  const std::uint32_t b = cornerOf(mesh, place.face, (exit.slot + 2) % 3);
  const std::size_t at_a = slotOf(mesh, next, a), at_b = slotOf(mesh, next, b);
  const bool turned = (at_a + 1) % 3 == at_b;  // both faces run along the edge the same way
  return {next, place.reversed != turned, exit.point, 3 - at_a - at_b};
}

class LineWalk
{
 public:
  LineWalk(const WalkMesh& mesh, const Cut& cut, const WalkOptions& options, WalkTrace* trace)
      : mesh_(mesh), cut_(cut), options_(options), trace_(trace)
  {
  }

  Walk run(Place place)
  {
    walk_.end = WalkEnd::ARRIVED;
    Place told = place;  // the last place in a face that has a plane
    // Moved up ever more rarely: a way that is a loop meets it again (R. Brent's way to find one).
    Place met{NO_INDEX, false, {}};
    std::size_t next_move = 1;
    for (std::size_t steps = 0; cut_.goal() > 0.0; ++steps) {
      CutExit exit = exitOf(mesh_, cut_, place);
      if (exit.slot == 3) {
        walk_.end = WalkEnd::NOWHERE;
        break;
      }
      const double before = cut_.progress(place.point), after = cut_.progress(exit.point);
      const bool arrives = after >= cut_.goal();
      if (arrives && after > before) {
        exit.point = between(place.point, exit.point, (cut_.goal() - before) / (after - before));
      }
      follow(place, exit.point);
      place.point = exit.point;
      told = longestSideFirst(mesh_, place.face, place.reversed).hasArea() ? place : told;
      if (arrives) {
        break;
      }
      const std::uint32_t next = faceAcross(mesh_, place.face, exit.slot);
      walk_.end = endAt(next, steps);
      if (walk_.end != WalkEnd::ARRIVED) {
        break;
      }
      place = across(mesh_, place, exit, next);
      if (place.face == met.face && place.entry == met.entry) {
        walk_.end = WalkEnd::LOOP;
        break;
      }
      if (steps + 1 == next_move) {
        met = place;
        next_move *= 2;
      }
    }
    stand(told);
    return walk_;
  }

 private:
  WalkEnd endAt(std::uint32_t next, std::size_t steps) const
  {
    if (next == NO_INDEX) {
      return WalkEnd::BORDER;
    }
    if (!options_.mask.empty() && options_.mask[next] == 0) {
      return WalkEnd::BLOCKED;
    }
    return steps >= options_.max_steps ? WalkEnd::STEPS : WalkEnd::ARRIVED;
  }

  void follow(const Place& place, const Vector3& to)
  {
    const Vector3 step = to - place.point;
    const double distance = std::sqrt(dot(step, step));
    if (!(distance > 0.0)) {
      return;
    }
    walk_.length += distance;
    walk_.pose.direction = {step[0] / distance, step[1] / distance, step[2] / distance};
    if (trace_ != nullptr) {
      const Vector3 point = cut_.inSpace(to);
      trace_->points.insert(trace_->points.end(), point.begin(), point.end());
      trace_->faces.push_back(place.face);
    }
  }

  void stand(const Place& place)
  {
    const FlatFace flat = longestSideFirst(mesh_, place.face, place.reversed);
    walk_.pose.face = place.face;
    walk_.pose.barycentric = flat.barycentric(flat.flat(place.point - cut_.local(flat.vertex(0))));
    walk_.pose.up = flat.normal();
    walk_.position = flat.positionOf(walk_.pose.barycentric);
  }

  const WalkMesh& mesh_;
  const Cut& cut_;
  const WalkOptions& options_;
  WalkTrace* trace_;
  Walk walk_;
};

}  // namespace

Walk walkLine(const WalkMesh& mesh, const WalkPose& start, const std::array<double, 3>& target,
              const WalkOptions& options, WalkTrace* trace)
{
  checkWalk(mesh, options);
  Walk nowhere;
  nowhere.pose = start;
  if (!canStart(mesh, start) || !isFinite(target)) {
    return nowhere;
  }
  const FlatFace face = startFace(mesh, start);
  if (!face.hasArea()) {
    return nowhere;
  }
  std::array<double, 3> inside;
  for (std::size_t k = 0; k < 3; ++k) {
    inside[k] = (1.0 - INTO_FACE) * start.barycentric[k] + INTO_FACE / 3.0;
  }
  const Vector3 up = start.up == Vector3{} ? face.normal() : ofSizeOne(start.up);
  const Cut cut(mesh, face, face.point(inside), up, target);
  beginTrace(trace, cut.inSpace(cut.start()));
  const bool reversed = (face.slot(0) + 1) % 3 != face.slot(1);
  return LineWalk(mesh, cut, options, trace).run({face.face(), reversed, cut.start()});
}

}  // namespace mesh_map
