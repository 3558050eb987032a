#include <mesh_map/base/run_options.h>
#include <mesh_map/paths/geodesic.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "paths/geodesic_legs.h"
#include "paths/geodesic_strip.h"

namespace mesh_map {

namespace {

constexpr double ALL_ROUND = 2.0 * PI - 1e-9;

/// The one other face at an edge; NO_INDEX: none, or several, or it must not be entered.
std::uint32_t faceBeyond(const FaceChoice& choice, std::uint32_t face, std::uint32_t edge)
{
  const RowsView& rows = choice.mesh.edge_faces;
  const std::uint32_t begin = rows.offsets[edge];
  if (rows.offsets[edge + 1] - begin != 2 || !canCross(choice.mesh, face, edge)) {
    return NO_INDEX;
  }
  const std::uint32_t other = rows.values[rows.values[begin] == face ? begin + 1 : begin];
  return choice.allows(other) ? other : NO_INDEX;
}

/// The strips that lead past a vertex beside a strip on its other side. Only vertices with less
/// than 360 degrees of surface around them are passed on both sides by taut paths (theorem of Gauss
/// and Bonnet), and only those that the surface goes all the way around can be.
class HillSides
{
 public:
  HillSides(const FaceChoice& choice, const Strip& strip) : choice_(choice), strip_(strip) {}

  /// One after the other; nothing at the end.
  std::optional<Strip> next()
  {
    while (edge_ < strip_.edges.size()) {
      const std::size_t first = edge_;
      const std::uint32_t vertex =
          endsOf(choice_.mesh, strip_.faces[first], strip_.edges[first])[end_];
      edge_ += end_;
      end_ = 1 - end_;
      if (first > 0 && hasEnd(first - 1, vertex)) {
        continue;  // it has been passed
      }
      std::size_t last = first;
      while (last + 1 < strip_.edges.size() && hasEnd(last + 1, vertex)) {
        ++last;
      }
      std::optional<Strip> strip = around(vertex, first, last);
      if (strip) {
        return strip;
      }
    }
    return std::nullopt;
  }

 private:
  std::optional<Strip> around(std::uint32_t vertex, std::size_t first, std::size_t last) const
  {
    const WalkMesh& mesh = choice_.mesh;
    double angle = 0.0;
    for (std::size_t i = first; i <= last + 1; ++i) {
      angle += CornerSides(mesh, strip_.faces[i], vertex).angle(mesh);
    }
    Strip strip = strip_.part(0, first);
    std::uint32_t face = strip_.faces[first];
    std::uint32_t edge = CornerSides(mesh, face, vertex).otherEdge(strip_.edges[first]);
    while (true) {
      face = faceBeyond(choice_, face, edge);
      if (face == NO_INDEX) {
        return std::nullopt;
      }
      strip.cross(edge, face);
      if (face == strip_.faces[last + 1]) {
        break;
      }
      const CornerSides sides(mesh, face, vertex);
      angle += sides.angle(mesh);
      if (angle >= ALL_ROUND) {
        return std::nullopt;
      }
      edge = sides.otherEdge(edge);
    }
    if (angle >= ALL_ROUND) {
      return std::nullopt;
    }
    for (std::size_t i = last + 1; i < strip_.edges.size(); ++i) {
      strip.cross(strip_.edges[i], strip_.faces[i + 1]);
    }
    return strip;
  }

  bool hasEnd(std::size_t edge, std::uint32_t vertex) const
  {
    const auto ends = endsOf(choice_.mesh, strip_.faces[edge], strip_.edges[edge]);
    return ends[0] == vertex || ends[1] == vertex;
  }

  const FaceChoice& choice_;
  const Strip& strip_;
  std::size_t edge_ = 0, end_ = 0;  // of the strip, and of its edge: what is to come
};

/// An angle that lacks less than this of 180 degrees counts as straight.
constexpr double STRAIGHT = 1e-8;

/// Of the length: less is no gain.
constexpr double NO_GAIN = 1e-15;

/// Of the length: for less it is not worth to take another side of a hill.
constexpr double NO_HILL = 1e-10;

/// A way over a hill that is longer by more than this part of its length is not looked into.
constexpr double TOO_LONG = 0.02;

/// How often it is pulled taut before it is compared.
constexpr std::size_t HILL_PASSES = 20;

/// A path that is being pulled taut.
class TautPath
{
 public:
  TautPath(const FaceChoice& choice, const GeodesicOptions& options, JoinedPath path)
      : choice_(choice),
        options_(options),
        start_(path.start),
        end_(path.end),
        legs_(std::move(path.legs))
  {
    cutLoops();
  }

  /// Until nothing is left to gain, or `passes` passes are made.
  void settle(Geodesic& result, std::size_t passes)
  {
    for (std::size_t i = 0; i < passes && pass(result); ++i) {
    }
  }

  /// The other side of all hills beside it; true if the path is another one then.
  bool tryHills(Geodesic& result)
  {
    Legs old = std::exchange(legs_, {});
    bool changed = false;
    for (std::size_t i = 0; i < old.legs.size(); ++i) {
      const Joint& from = i == 0 ? start_ : old.joints[i - 1];
      const Joint& to = i < old.joints.size() ? old.joints[i] : end_;
      std::optional<Legs> shorter = overHills(old.legs[i], from, to, result);
      if (shorter) {
        changed = true;
        legs_.append(std::move(*shorter));
      } else {
        legs_.legs.push_back(std::move(old.legs[i]));
      }
      if (i < old.joints.size()) {
        legs_.joints.push_back(old.joints[i]);
        legs_.joints.back().settled = false;
      }
    }
    return changed && !result.canceled && tried_ < options_.max_turns;
  }

  WalkTrace trace() const
  {
    WalkTrace path;
    path.points.assign(start_.position.begin(), start_.position.end());
    for (std::size_t i = 0; i < legs_.legs.size(); ++i) {
      const Joint& from = i == 0 ? start_ : legs_.joints[i - 1];
      const Joint& to = i + 1 == legs_.legs.size() ? end_ : legs_.joints[i];
      traceLeg(choice_.mesh, legs_.legs[i], from.position, to.position, path);
    }
    return path;
  }

 private:
  // One pass over all joints; true if there is more to do. Legs double in length with each, so that
  // none is laid out often.
  bool pass(Geodesic& result)
  {
    if (legs_.legs.empty()) {
      return false;
    }
    Legs old = std::exchange(legs_, {});
    bool is_new = false, open = false;  // of the last leg of legs_
    legs_.legs.push_back(std::move(old.legs[0]));
    for (std::size_t j = 0; j < old.joints.size(); ++j) {
      Joint joint = old.joints[j];
      Leg& after = old.legs[j + 1];
      if (isCanceled(result)) {
        return false;
      }
      if (!joint.settled && joint.vertex != NO_INDEX && !is_new) {
        const Joint& to = j + 1 < old.joints.size() ? old.joints[j + 1] : end_;
        std::optional<Legs> shorter = around(joint, after, to);
        joint.settled = !shorter;
        if (shorter) {
          legs_.legs.pop_back();
          if (!legs_.joints.empty()) {
            legs_.joints.back().settled = false;
          }
          if (j + 1 < old.joints.size()) {
            old.joints[j + 1].settled = false;
          }
          legs_.append(std::move(*shorter));
          is_new = open = true;
          ++result.turns;
          continue;
        }
      }
      open = open || (!joint.settled && joint.vertex != NO_INDEX);
      legs_.joints.push_back(joint);
      legs_.legs.push_back(std::move(after));
      is_new = false;
    }
    if (open) {
      cutLoops();
    }
    result.settled = !open;
    return open && tried_ < options_.max_turns;
  }

  // Leaves out what is between two visits of a vertex.
  void cutLoops()
  {
    Legs kept;  // with the joint after each leg
    std::unordered_map<std::uint32_t, std::size_t> legs_before;
    legs_before[start_.vertex] = 0;
    for (std::size_t i = 0; i < legs_.legs.size(); ++i) {
      kept.legs.push_back(std::move(legs_.legs[i]));
      kept.joints.push_back(i < legs_.joints.size() ? legs_.joints[i] : end_);
      const std::uint32_t vertex = kept.joints.back().vertex;
      const auto [visit, is_first] = legs_before.try_emplace(vertex, kept.legs.size());
      if (vertex == NO_INDEX || is_first) {
        continue;
      }
      const std::size_t count = visit->second;
      for (std::size_t k = count; k + 1 < kept.joints.size(); ++k) {
        legs_before.erase(kept.joints[k].vertex);
      }
      kept.legs.erase(kept.legs.begin() + static_cast<std::ptrdiff_t>(count), kept.legs.end());
      kept.joints.resize(count);
      if (count > 0) {
        kept.joints.back().settled = false;
      }
    }
    if (!kept.joints.empty()) {
      kept.joints.pop_back();
    }
    legs_ = std::move(kept);
  }

  // The last leg of the way so far and the next one, on another side of the joint between them, if
  // that is shorter.
  std::optional<Legs> around(const Joint& joint, const Leg& after, const Joint& to)
  {
    const Leg& before = legs_.legs.back();
    std::optional<Turn> turn =
        turnBelow(choice_, joint.vertex, before.at_end, after.at_start, PI - STRAIGHT);
    if (!turn) {
      return std::nullopt;
    }
    ++tried_;
    Strip strip = before.strip;
    turn->faces.insert(turn->faces.end(), after.strip.faces[0]);
    for (std::size_t i = 0; i < turn->edges.size(); ++i) {
      strip.cross(turn->edges[i], turn->faces[i]);
    }
    for (std::size_t i = 0; i < after.strip.edges.size(); ++i) {
      strip.cross(after.strip.edges[i], after.strip.faces[i + 1]);
    }
    const Joint& from = legs_.joints.empty() ? start_ : legs_.joints.back();
    std::optional<Legs> shorter = straighten(choice_.mesh, std::move(strip), from, to);
    const double given = before.length + after.length;
    return shorter && shorter->length() < given * (1.0 - NO_GAIN) ? std::move(shorter)
                                                                  : std::nullopt;
  }

  // The first way on another side of a hill that is shorter than a leg.
  std::optional<Legs> overHills(const Leg& leg, const Joint& from, const Joint& to,
                                Geodesic& result)
  {
    HillSides sides(choice_, leg.strip);
    while (std::optional<Strip> strip = sides.next()) {
      if (isCanceled(result) || ++tried_ >= options_.max_turns) {
        break;
      }
      std::optional<Legs> legs = straighten(choice_.mesh, std::move(*strip), from, to);
      if (!legs || legs->length() > leg.length * (1.0 + TOO_LONG)) {
        continue;
      }
      TautPath other(choice_, options_, {from, to, std::move(*legs)});
      other.settle(result, HILL_PASSES);
      tried_ += other.tried_;
      if (!other.legs_.legs.empty() && other.legs_.length() < leg.length * (1.0 - NO_HILL)) {
        return std::move(other.legs_);
      }
    }
    return std::nullopt;
  }

  bool isCanceled(Geodesic& result) const
  {
    result.canceled = result.canceled || isSet(options_.cancel);
    return result.canceled;
  }

  const FaceChoice choice_;
  const GeodesicOptions options_;
  const Joint start_, end_;
  Legs legs_;
  std::size_t tried_ = 0;
};

/// Of the length of a path: what is shorter is nothing.
constexpr double NOTHING = 1e-12;

double lengthOf(const WalkTrace& path)
{
  double sum = 0.0;
  for (std::size_t i = 0; i < path.faces.size(); ++i) {
    sum += distance(pointAt(path, i), pointAt(path, i + 1));
  }
  return sum;
}

/// A path without segments that are nothing; its ends stay.
WalkTrace cleaned(const WalkTrace& path, double length)
{
  const auto isNothing = [&](const Vector3& a, const Vector3& b) {
    return dot(b - a, b - a) <= NOTHING * NOTHING * length * length;
  };
  WalkTrace result;
  const auto append = [&](std::size_t i) {
    result.points.insert(result.points.end(), path.points.data() + 3 * i,
                         path.points.data() + 3 * i + 3);
  };
  const Vector3 end = pointAt(path, path.faces.size());
  std::size_t last = path.faces.size();  // from this point on, there is nothing but the end
  while (last > 0 && isNothing(pointAt(path, last - 1), end)) {
    --last;
  }
  append(0);
  for (std::size_t i = 0; i < last; ++i) {
    const bool is_end = i + 1 == last;
    if (is_end || !isNothing(pointAt(result, result.faces.size()), pointAt(path, i + 1))) {
      result.faces.push_back(path.faces[i]);
      append(is_end ? path.faces.size() : i + 1);
    }
  }
  return result;
}

}  // namespace

Geodesic shortenPath(const WalkMesh& mesh, const WalkTrace& path, const GeodesicOptions& options)
{
  checkPath(mesh, path, options.mask);
  Geodesic result;
  result.path = path;
  result.length = lengthOf(path);
  if (path.faces.empty()) {
    return result;
  }
  const FaceChoice choice{mesh, options.mask};
  std::optional<JoinedPath> given = joined(choice, path);
  if (!given) {
    return result;
  }
  TautPath taut(choice, options, std::move(*given));
  taut.settle(result, options.max_turns);
  while (options.over_hills && taut.tryHills(result)) {
    taut.settle(result, options.max_turns);
  }
  if (result.canceled) {
    return {{}, 0.0, result.turns, false, true};
  }
  WalkTrace shorter = cleaned(taut.trace(), result.length);
  const double length = lengthOf(shorter);
  if (length <= result.length) {
    result.path = std::move(shorter);
    result.length = length;
  }
  return result;
}

}  // namespace mesh_map
