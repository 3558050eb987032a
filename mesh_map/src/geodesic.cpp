#include <mesh_map/geodesic.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geodesic_input.h"
#include "geodesic_legs.h"
#include "geodesic_turn.h"

namespace mesh_map {
namespace {

constexpr double PI = 3.14159265358979323846;

/// An angle that lacks less than this of 180 degrees counts as straight.
constexpr double STRAIGHT = 1e-8;

/// Of the length of a path: what is shorter is nothing.
constexpr double NOTHING = 1e-12;

/// Of the length: less is no gain.
constexpr double NO_GAIN = 1e-15;

double lengthOf(const WalkTrace& path)
{
  double sum = 0.0;
  for (std::size_t i = 0; i < path.faces.size(); ++i) {
    const Vector3 step = pointAt(path, i + 1) - pointAt(path, i);
    sum += std::sqrt(dot(step, step));
  }
  return sum;
}

/// A path that is being pulled taut.
class TautPath
{
 public:
  TautPath(const FaceChoice& choice, const GeodesicOptions& options)
      : choice_(choice), options_(options)
  {
  }

  /// False where that cannot be told.
  bool take(const Stretches& path)
  {
    start_ = path.joints.front();
    end_ = path.joints.back();
    for (std::size_t i = 0; i < path.stretches.size(); ++i) {
      const Joint &from = path.joints[i], &to = path.joints[i + 1];
      if (i > 0) {
        way_.joints.push_back(from);
      }
      if (path.stretches[i].stays) {
        way_.legs.push_back(
            fixedLeg(path.stretches[i].strip.faces[0], from.position, to.position));
        continue;
      }
      std::optional<Legs> legs = straighten(choice_.mesh, path.stretches[i].strip, from, to);
      if (!legs) {
        return false;
      }
      append(way_, std::move(*legs));
    }
    cutLoops();
    return true;
  }

  /// One pass over all joints; true if there is more to do. Legs double in length with each, so
  /// that none is laid out often.
  bool pass(Geodesic& result)
  {
    if (way_.legs.empty()) {
      return false;
    }
    Legs old = std::exchange(way_, {});
    bool is_new = false, open = false;  // of the last leg of way_
    way_.legs.push_back(std::move(old.legs[0]));
    for (std::size_t j = 0; j < old.joints.size(); ++j) {
      Joint joint = old.joints[j];
      Leg& after = old.legs[j + 1];
      if (options_.cancel != nullptr && options_.cancel->load(std::memory_order_relaxed)) {
        result.cancelled = true;
        return false;
      }
      if (!joint.settled && joint.vertex != NO_INDEX && !is_new) {
        const Joint& to = j + 1 < old.joints.size() ? old.joints[j + 1] : end_;
        std::optional<Legs> shorter = around(joint, after, to);
        joint.settled = !shorter;
        if (shorter) {
          way_.legs.pop_back();
          if (!way_.joints.empty()) {
            way_.joints.back().settled = false;
          }
          if (j + 1 < old.joints.size()) {
            old.joints[j + 1].settled = false;
          }
          append(way_, std::move(*shorter));
          is_new = open = true;
          ++result.turns;
          continue;
        }
      }
      open = open || (!joint.settled && joint.vertex != NO_INDEX);
      way_.joints.push_back(joint);
      way_.legs.push_back(std::move(after));
      is_new = false;
    }
    if (open) {
      cutLoops();
    }
    result.settled = !open;
    return open && tried_ < options_.max_turns;
  }

  WalkTrace trace() const
  {
    WalkTrace path;
    path.points.assign(start_.position.begin(), start_.position.end());
    for (std::size_t i = 0; i < way_.legs.size(); ++i) {
      const Joint& from = i == 0 ? start_ : way_.joints[i - 1];
      const Joint& to = i + 1 == way_.legs.size() ? end_ : way_.joints[i];
      traceLeg(choice_.mesh, way_.legs[i], from.position, to.position, path);
    }
    return path;
  }

 private:
  static void append(Legs& way, Legs&& more)
  {
    std::move(more.legs.begin(), more.legs.end(), std::back_inserter(way.legs));
    way.joints.insert(way.joints.end(), more.joints.begin(), more.joints.end());
  }

  /// Leaves out what is between two visits of a vertex.
  void cutLoops()
  {
    Legs kept;  // with the joint after each leg
    std::unordered_map<std::uint32_t, std::size_t> legs_before;
    legs_before[start_.vertex] = 0;
    for (std::size_t i = 0; i < way_.legs.size(); ++i) {
      kept.legs.push_back(std::move(way_.legs[i]));
      kept.joints.push_back(i < way_.joints.size() ? way_.joints[i] : end_);
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
    way_ = std::move(kept);
  }

  /// The last leg of the way so far and the next one, on another side of the joint between them, if
  /// that is shorter.
  std::optional<Legs> around(const Joint& joint, const Leg& after, const Joint& to)
  {
    const Leg& before = way_.legs.back();
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
    const Joint& from = way_.joints.empty() ? start_ : way_.joints.back();
    std::optional<Legs> shorter = straighten(choice_.mesh, std::move(strip), from, to);
    const double given = before.length + after.length;
    return shorter && shorter->length() < given * (1.0 - NO_GAIN) ? std::move(shorter)
                                                                  : std::nullopt;
  }

  const FaceChoice choice_;
  const GeodesicOptions options_;
  Joint start_{}, end_{};
  Legs way_;
  std::size_t tried_ = 0;
};

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
  TautPath taut(choice, options);
  if (!taut.take(stretchesOf(choice, path))) {
    return result;
  }
  while (taut.pass(result)) {
  }
  if (result.cancelled) {
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
