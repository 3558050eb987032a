#include "paths/geodesic_legs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "paths/geodesic_strip.h"

namespace mesh_map {

namespace {

/// A vertex at which a taut path bends, and the portals (first to last) that end there.
struct Bend
{
  std::uint32_t vertex;
  std::size_t first, last;
};

constexpr std::size_t NONE = static_cast<std::size_t>(-1);

/// Angles below are rounding.
constexpr double STRAIGHT = 1e-12;

/// What can be seen so far: two taut strings from one apex, to the left and the right end of a
/// portal. They lie in one array: left end ... apex ... right end.
class Funnel
{
 public:
  explicit Funnel(std::size_t portal_count)
      : chain_(2 * portal_count + 5), begin_(portal_count + 2), end_(begin_), apex_(begin_)
  {
    points_.reserve(portal_count + 3);
    points_.push_back({{}, {NO_INDEX, 0, 0}, NONE});
  }

  void start(const Vector2& at)
  {
    points_[0].at = at;
    chain_[apex_] = 0;
  }

  void addLeft(const Vector2& at, const Bend& bend)
  {
    while (begin_ < end_ && isHiddenLeft(at)) {
      ++begin_;
      apex_ = std::max(apex_, begin_);
    }
    points_.push_back({at, bend, chain_[begin_]});
    chain_[--begin_] = points_.size() - 1;
  }

  void addRight(const Vector2& at, const Bend& bend)
  {
    while (begin_ < end_ && isHiddenRight(at)) {
      --end_;
      apex_ = std::min(apex_, end_);
    }
    points_.push_back({at, bend, chain_[end_]});
    chain_[++end_] = points_.size() - 1;
  }

  /// The ends of the two strings go on to the next portal.
  void keepLeft() { ++points_[chain_[begin_]].bend.last; }
  void keepRight() { ++points_[chain_[end_]].bend.last; }

  /// The bends on the way to what was added last.
  std::vector<Bend> bends() const
  {
    std::vector<Bend> bends;
    for (std::size_t i = points_.back().before; i != 0; i = points_[i].before) {
      bends.push_back(points_[i].bend);
    }
    std::reverse(bends.begin(), bends.end());
    return bends;
  }

 private:
  struct Point
  {
    Vector2 at;
    Bend bend;
    std::size_t before;  // on the way here
  };

  const Vector2& at(std::size_t i) const { return points_[chain_[i]].at; }

  // Whether the way to a point leaves out the end of the string on its side.
  bool isHiddenLeft(const Vector2& point) const
  {
    const Vector2 &p = at(begin_), &q = at(begin_ + 1);
    return begin_ < apex_ ? turn(q, p, point) <= 0 : isPast(p, q, point, -1);
  }
  bool isHiddenRight(const Vector2& point) const
  {
    const Vector2 &p = at(end_), &q = at(end_ - 1);
    return end_ > apex_ ? turn(q, p, point) >= 0 : isPast(p, q, point, 1);
  }

  // Whether the way from p to a point leads around q, from where `side` (1 left, -1 right) of it is
  // hidden. What is straight beyond q is: a face without area may turn the next point right back.
  static bool isPast(const Vector2& p, const Vector2& q, const Vector2& point, int side)
  {
    const int turned = turn(p, q, point);
    return turned == side || (turned == 0 && dot(q - p, point - q) >= 0.0);
  }

  // Of the way from p over q: 1 to the left, -1 to the right, 0 straight on or back.
  static int turn(const Vector2& p, const Vector2& q, const Vector2& point)
  {
    const Vector2 a = q - p, b = point - q;
    const double sine = cross(a, b), least = STRAIGHT * STRAIGHT * dot(a, a) * dot(b, b);
    return sine * sine <= least ? 0 : sine > 0.0 ? 1 : -1;
  }

  std::vector<Point> points_;
  std::vector<std::size_t> chain_;
  std::size_t begin_, end_, apex_;
};

/// Where the shortest path through an unfolded strip bends, in its order. In linear time.
std::vector<Bend> funnel(const Unfolding& strip)
{
  const std::vector<Portal>& portals = strip.portals;
  Funnel taut(portals.size());
  taut.start(strip.from);
  taut.addLeft(portals[0].at_left, {portals[0].left, 0, 0});
  taut.addRight(portals[0].at_right, {portals[0].right, 0, 0});
  for (std::size_t i = 1; i < portals.size(); ++i) {
    if (portals[i].left != portals[i - 1].left) {
      taut.keepRight();
      taut.addLeft(portals[i].at_left, {portals[i].left, i, i});
    } else {
      taut.keepLeft();
      taut.addRight(portals[i].at_right, {portals[i].right, i, i});
    }
  }
  taut.addLeft(strip.to, {NO_INDEX, portals.size(), portals.size()});
  return taut.bends();
}

/// A leg that is straight in its strip.
Leg straightLeg(const WalkMesh& mesh, Strip strip, const Joint& from, const Joint& to)
{
  Leg leg{std::move(strip)};
  const std::vector<std::uint32_t>&faces = leg.strip.faces, &edges = leg.strip.edges;
  if (edges.empty()) {
    leg.length = distance(from.position, to.position);
    if (from.vertex != NO_INDEX) {
      leg.at_start = directionTo(mesh, faces[0], from.vertex, to.position);
    }
    if (to.vertex != NO_INDEX) {
      leg.at_end = directionTo(mesh, faces[0], to.vertex, from.position);
    }
    return leg;
  }
  const Unfolding unfolded(mesh, leg.strip, from.position, to.position);
  const Vector2 way = unfolded.to - unfolded.from;
  leg.length = norm(way);
  if (from.vertex != NO_INDEX) {
    leg.at_start =
        directionAlong(mesh, faces.front(), edges.front(), unfolded.portals.front(), -1.0, way);
  }
  if (to.vertex != NO_INDEX) {
    leg.at_end =
        directionAlong(mesh, faces.back(), edges.back(), unfolded.portals.back(), 1.0, -way);
  }
  return leg;
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
  return {{{face}, {}}, distance(from, to), {}, {}};
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
    Strip piece = strip.part(first, last);
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
    const Vector3 point = left + shares[i] * (right - left);
    trace.points.insert(trace.points.end(), point.begin(), point.end());
  }
  trace.faces.push_back(leg.strip.faces.back());
  trace.points.insert(trace.points.end(), to.begin(), to.end());
}

}  // namespace mesh_map
