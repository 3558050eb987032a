#include "paths/geodesic_legs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/require.h"
#include "bvh/closest/triangle_point.h"

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
  Funnel(std::size_t portal_count, const Vector2& apex)
      : chain_(2 * portal_count + 5),
        ends_{portal_count + 2, portal_count + 2},
        apex_(portal_count + 2)
  {
    points_.reserve(portal_count + 3);
    points_.push_back({apex, {NO_INDEX, 0, 0}, NONE});
  }

  /// The string to the left (0) or the right (1) ends at a point now.
  void add(std::size_t side, const Vector2& at, const Bend& bend)
  {
    std::size_t& end = ends_[side];
    while (ends_[0] < ends_[1] && isHidden(side, at)) {
      end += inwards(side);
      apex_ = std::clamp(apex_, ends_[0], ends_[1]);
    }
    points_.push_back({at, bend, chain_[end]});
    end -= inwards(side);
    chain_[end] = points_.size() - 1;
  }

  /// The end of a string goes on to the next portal.
  void keep(std::size_t side) { ++points_[chain_[ends_[side]]].bend.last; }

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

  static int inwards(std::size_t side) { return side == 0 ? 1 : -1; }

  // Whether the way to a point leaves out the end of the string on its side.
  bool isHidden(std::size_t side, const Vector2& point) const
  {
    const int step = inwards(side);
    const Vector2 &p = at(ends_[side]), &q = at(ends_[side] + step);
    return ends_[side] != apex_ ? step * turn(q, p, point) <= 0 : isPast(p, q, point, -step);
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
  std::array<std::size_t, 2> ends_;
  std::size_t apex_;
};

/// Where the shortest path through an unfolded strip bends, in its order. In linear time.
std::vector<Bend> funnel(const Unfolding& strip)
{
  const std::vector<Portal>& portals = strip.portals;
  Funnel taut(portals.size(), strip.from);
  const auto add = [&](std::size_t i, std::size_t side) {
    taut.add(side, portals[i].at[side], {portals[i].ends[side], i, i});
  };
  add(0, 0);
  add(0, 1);
  for (std::size_t i = 1; i < portals.size(); ++i) {
    const std::size_t changed = portals[i].ends[0] != portals[i - 1].ends[0] ? 0 : 1;
    taut.keep(1 - changed);
    add(i, changed);
  }
  taut.add(0, strip.to, {NO_INDEX, portals.size(), portals.size()});
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

void Legs::append(Legs&& more)
{
  std::move(more.legs.begin(), more.legs.end(), std::back_inserter(legs));
  joints.insert(joints.end(), more.joints.begin(), more.joints.end());
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
    const Vector3 left = pointOf(mesh, unfolded.portals[i].ends[0]);
    const Vector3 right = pointOf(mesh, unfolded.portals[i].ends[1]);
    trace.faces.push_back(leg.strip.faces[i]);
    const Vector3 point = left + shares[i] * (right - left);
    trace.points.insert(trace.points.end(), point.begin(), point.end());
  }
  trace.faces.push_back(leg.strip.faces.back());
  trace.points.insert(trace.points.end(), to.begin(), to.end());
}

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

/// A part of a path, from a joint on, that is to be straightened in its strip, or to stay. The
/// joint has its vertex only where the stretches on both sides may move (or that is the start).
struct Stretch
{
  Joint from;
  Strip strip;
  bool stays;
};

std::vector<Stretch> stretchesOf(const FaceChoice& choice, const WalkTrace& path)
{
  const WalkMesh& mesh = choice.mesh;
  std::vector<Stretch> result;
  const auto begin = [&](const Vector3& point, std::uint32_t vertex, std::uint32_t face,
                         bool stays) {
    result.push_back({{point, vertex}, {{face}, {}}, stays});
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
    Stretch& last = result.back();
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
  return result;
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

std::optional<JoinedPath> joined(const FaceChoice& choice, const WalkTrace& path)
{
  const std::vector<Stretch> stretches = stretchesOf(choice, path);
  const Vector3 end = pointAt(path, path.faces.size());
  JoinedPath result{stretches[0].from, {}, {}};
  result.end = {end, cornerAt(choice.mesh, stretches.back().strip.faces.back(), end)};
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const Joint& from = stretches[i].from;
    const Joint& to = i + 1 < stretches.size() ? stretches[i + 1].from : result.end;
    if (i > 0) {
      result.legs.joints.push_back(from);
    }
    if (stretches[i].stays) {
      const double length = distance(from.position, to.position);
      result.legs.legs.push_back({stretches[i].strip, length, {}, {}});
      continue;
    }
    std::optional<Legs> legs = straighten(choice.mesh, stretches[i].strip, from, to);
    if (!legs) {
      return std::nullopt;
    }
    result.legs.append(std::move(*legs));
  }
  return result;
}

}  // namespace mesh_map
