#include "geodesic_taut.h"

#include <iterator>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geodesic_hills.h"

namespace mesh_map {
namespace {

constexpr double PI = 3.14159265358979323846;

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

void append(Legs& way, Legs&& more)
{
  std::move(more.legs.begin(), more.legs.end(), std::back_inserter(way.legs));
  way.joints.insert(way.joints.end(), more.joints.begin(), more.joints.end());
}

}  // namespace

bool TautPath::take(const Stretches& path)
{
  start_ = path.joints.front();
  end_ = path.joints.back();
  for (std::size_t i = 0; i < path.stretches.size(); ++i) {
    const Joint &from = path.joints[i], &to = path.joints[i + 1];
    if (i > 0) {
      way_.joints.push_back(from);
    }
    if (path.stretches[i].stays) {
      way_.legs.push_back(fixedLeg(path.stretches[i].strip.faces[0], from.position, to.position));
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

bool TautPath::isCancelled(Geodesic& result) const
{
  result.cancelled = result.cancelled || (options_.cancel != nullptr &&
                                          options_.cancel->load(std::memory_order_relaxed));
  return result.cancelled;
}

void TautPath::settle(Geodesic& result, std::size_t passes)
{
  for (std::size_t i = 0; i < passes && pass(result); ++i) {
  }
}

// One pass over all joints; true if there is more to do. Legs double in length with each, so that
// none is laid out often.
bool TautPath::pass(Geodesic& result)
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
    if (isCancelled(result)) {
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

WalkTrace TautPath::trace() const
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

// Leaves out what is between two visits of a vertex.
void TautPath::cutLoops()
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

// The last leg of the way so far and the next one, on another side of the joint between them, if
// that is shorter.
std::optional<Legs> TautPath::around(const Joint& joint, const Leg& after, const Joint& to)
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
  return shorter && shorter->length() < given * (1.0 - NO_GAIN) ? std::move(shorter) : std::nullopt;
}

bool TautPath::tryHills(Geodesic& result)
{
  Legs old = std::exchange(way_, {});
  bool changed = false;
  for (std::size_t i = 0; i < old.legs.size(); ++i) {
    const Joint& from = i == 0 ? start_ : old.joints[i - 1];
    const Joint& to = i < old.joints.size() ? old.joints[i] : end_;
    std::optional<Legs> shorter = overHills(old.legs[i], from, to, result);
    if (shorter) {
      changed = true;
      append(way_, std::move(*shorter));
    } else {
      way_.legs.push_back(std::move(old.legs[i]));
    }
    if (i < old.joints.size()) {
      way_.joints.push_back(old.joints[i]);
      way_.joints.back().settled = false;
    }
  }
  return changed && !result.cancelled && tried_ < options_.max_turns;
}

// The first way on another side of a hill that is shorter than a leg.
std::optional<Legs> TautPath::overHills(const Leg& leg, const Joint& from, const Joint& to,
                                        Geodesic& result)
{
  HillSides sides(choice_, leg.strip);
  while (std::optional<Strip> strip = sides.next()) {
    if (isCancelled(result) || ++tried_ >= options_.max_turns) {
      break;
    }
    std::optional<Legs> legs = straighten(choice_.mesh, std::move(*strip), from, to);
    if (!legs || legs->length() > leg.length * (1.0 + TOO_LONG)) {
      continue;
    }
    TautPath other(choice_, options_);
    other.start_ = from;
    other.end_ = to;
    other.way_ = std::move(*legs);
    other.cutLoops();
    other.settle(result, HILL_PASSES);
    tried_ += other.tried_;
    if (!other.way_.legs.empty() && other.way_.length() < leg.length * (1.0 - NO_HILL)) {
      return std::move(other.way_);
    }
  }
  return std::nullopt;
}

}  // namespace mesh_map
