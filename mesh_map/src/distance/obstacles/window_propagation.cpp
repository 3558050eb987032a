#include "distance/obstacles/window_propagation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/unique.h"
#include "mesh/packed_position.h"

namespace mesh_map {
namespace {

/// How much longer a way has to be than another one (by this part of it) to count as longer:
/// above the rounding of labels, so that no best way ever ends.
constexpr double LONGER = 1e-6;

/// Windows are queued at least this part before what they can offer.
constexpr double EARLIER = 1e-9;

/// A window goes on by itself this many edges: that is cheaper than to queue it for each.
constexpr double AHEAD = 8.0;

constexpr std::uint32_t MOST_STANDING = 1024;

/// Entries of the queue that are vertices come after windows of the same distance.
constexpr std::uint32_t VERTEX = 0x80000000u;

constexpr std::uint32_t STEPS_PER_CANCEL_CHECK = 4096;

double bucketWidth(double mean_edge, double max_distance)
{
  return std::min(mean_edge / 4.0, std::max(mean_edge / 256.0, max_distance / 4000.0));
}

/// Bits that the place of a corner in its row does not need.
unsigned startBits(std::size_t corners)
{
  const auto last = static_cast<std::uint32_t>(corners - 1);
  return last > 1 ? static_cast<unsigned>(__builtin_clz(last)) : 31;
}

}  // namespace

std::uint32_t PathStart::pack(std::size_t corners, std::uint32_t corner, double along)
{
  const unsigned bits = startBits(corners);
  const double steps = static_cast<double>((std::uint32_t{1} << bits) - 1);
  return corner << bits | static_cast<std::uint32_t>(along * steps + 0.5);
}

PathStart PathStart::unpack(std::size_t corners, std::uint32_t packed)
{
  const unsigned bits = startBits(corners);
  const std::uint32_t steps = (std::uint32_t{1} << bits) - 1;
  const double step = steps > 0 ? 1.0 / steps : 1.0;
  return {packed >> bits, std::min(1.0, step * (packed & steps)), step};
}

WindowPropagation::WindowPropagation(const FastMarchingMesh& mesh, double max_distance)
    : mesh_(mesh),
      max_distance_(max_distance),
      labels_(mesh.vertexCount(), NO_LABEL),
      queue_(bucketWidth(mesh.meanEdge(), max_distance))
{
}

/// Asks for the memory of vertices that are popped soon. Inlined: see
/// FastMarchingUpdate::prefetch().
[[gnu::always_inline]] inline void WindowPropagation::prefetch() const
{
  const auto vertexAfter = [this](std::size_t count) {
    const std::uint32_t entry = queue_.peek(count);
    return entry != NO_INDEX && entry >= VERTEX ? entry - VERTEX : NO_INDEX;
  };
  const std::uint32_t latest = vertexAfter(LATEST), later = vertexAfter(LATER);
  const std::uint32_t soon = vertexAfter(SOON);
  if (latest != NO_INDEX) {
    prefetchVertex(latest);
  }
  if (later != NO_INDEX) {
    mesh_.prefetchCorners(later);
  }
  if (soon != NO_INDEX) {
    prefetchAround(soon);
  }
}

bool WindowPropagation::run(ArrayView<std::uint8_t> lethal, ArrayView<std::uint32_t> obstacles,
                            const WindowScope& scope, const std::atomic<bool>* cancel)
{
  lethal_ = lethal;
  scope_ = scope;
  is_all_in_scope_ = scope.isAll();
  queue_.clear();
  windows_.clear();
  free_.clear();
  for (const std::uint32_t v : reached_) {
    labels_[v] = NO_LABEL;
  }
  reached_.clear();
  seen_.clear();
  passed_.clear();
  for (const std::uint32_t v : obstacles) {
    labels_[v] = labelOf(0.0f, 0);
    reached_.push_back(v);
  }
  is_starting_ = true;
  start(obstacles);
  is_starting_ = false;
  for (std::size_t i = obstacles.size(); i < reached_.size(); ++i) {
    queue_.push(distanceOf(labels_[reached_[i]]), VERTEX | reached_[i]);
  }
  if (cancel != nullptr && cancel->load()) {
    return false;
  }
  DistanceEntry entry;
  for (std::uint32_t steps = 1; queue_.pop(entry); ++steps) {
    prefetch();
    if (entry.vertex >= VERTEX) {
      const std::uint32_t v = entry.vertex - VERTEX;
      if (entry.distance == distanceOf(labels_[v])) {
        leaveVertex(v);
      }
    } else {
      next_.push_back(windows_[entry.vertex]);
      free_.push_back(entry.vertex);
      follow();
    }
    if (steps % STEPS_PER_CANCEL_CHECK == 0 && cancel != nullptr && cancel->load()) {
      return false;
    }
  }
  return true;
}

/// Can it, or an edge at it, be near to where distances are wanted?
bool WindowPropagation::isInScope(std::uint32_t obstacle) const
{
  if (is_all_in_scope_ || gap(obstacle) <= max_distance_) {
    return true;
  }
  for (const FastMarchingCorner& corner : mesh_.corners(obstacle)) {
    for (const std::uint32_t u : {corner.a, corner.b}) {
      if (lethal_[u] != 0 && canReach(obstacle, u, std::sqrt(squaredLength(obstacle, u)), 0.0)) {
        return true;
      }
    }
  }
  return false;
}

/// Takes the windows of one source in next_ on into the faces behind their edges, and on from
/// these, those of the nearest edges at once: that is cheaper than to queue them.
void WindowPropagation::follow()
{
  if (next_.empty()) {
    return;
  }
  const double nearest = std::sqrt(next_.front().nearest) + AHEAD * mesh_.meanEdge();
  const double ahead = nearest * nearest;
  Window window;
  for (bool goes_on = false; goes_on || !next_.empty();) {
    if (!goes_on) {
      window = next_.back();
      next_.pop_back();
    }
    if (window.nearest > ahead) {
      queue(window);
      goes_on = false;
      continue;
    }
    const std::uint32_t third = mesh_.across(window.right, window.left, window.from);
    if (third != NO_INDEX) {
      goes_on = enter(window, third);
    } else {
      enterAll(window);
      goes_on = false;
    }
  }
}

/// Where more than two faces meet, or there is just one.
void WindowPropagation::enterAll(Window& window)
{
  const bool is_right = mesh_.corners(window.right).size() <= mesh_.corners(window.left).size();
  const std::uint32_t at = is_right ? window.right : window.left;
  const std::uint32_t other = is_right ? window.left : window.right;
  beyond_.clear();
  for (const FastMarchingCorner& corner : mesh_.corners(at)) {
    if (corner.a != corner.b && (corner.a == other || corner.b == other)) {
      const std::uint32_t third = corner.a == other ? corner.b : corner.a;
      if (third != window.from) {
        beyond_.push_back(third);
      }
    }
  }
  makeUnique(beyond_);
  if (beyond_.size() > 1 && !(isFirstOfItsKind(window) && isBestSomewhere(window))) {
    return;
  }
  for (const std::uint32_t third : beyond_) {
    Window part = window;
    if (enter(part, third)) {
      next_.push_back(part);
    }
  }
}

/// Where more than two faces meet at an edge, ways over faces that lie on each other come together
/// again: all but one of such windows end, or there would be twice as many behind each edge.
bool WindowPropagation::isFirstOfItsKind(const Window& window)
{
  const auto rounded = [](double value) {
    return std::uint64_t{bitsOf(static_cast<float>(value))} >> 4;
  };
  std::uint64_t kind = window.is_strip ? 1 : 0;
  for (const std::uint64_t part :
       {std::uint64_t{window.right} << 32 | window.left, rounded(window.offset + 1.0),
        rounded(window.distance(window.right_end)), rounded(window.distance(window.left_end)),
        rounded(window.nearest), rounded(1.0 + window.beside(window.right_ray, window.right_end)),
        rounded(1.0 + window.beside(window.left_ray, window.left_end))}) {
    kind = (kind ^ part) * 0x9E3779B97F4A7C15u;
    kind ^= kind >> 29;
  }
  return seen_.insert(kind).second;
}

/// Is it so behind the windows that have come to an edge of more than two faces before? Else there
/// would be twice as many behind each edge of faces that lie near to each other.
bool WindowPropagation::isBestSomewhere(Window& window)
{
  const std::uint32_t low = std::min(window.right, window.left);
  const std::uint32_t high = std::max(window.right, window.left);
  return cutBehind(passed_[std::uint64_t{low} << 32 | high], window);
}

/// Into the face with this third corner, and on to one of its two other edges. Where it goes to
/// both, what goes to the other one is added to next_. False where nothing goes on.
bool WindowPropagation::enter(Window& window, std::uint32_t beyond)
{
  mesh_.prefetchCorners(beyond);
  __builtin_prefetch(&labels_[beyond]);
  if (!(window.length > 0.0)) {
    return false;
  }
  const double from_right = squaredLength(window.right, beyond);
  const double from_left = squaredLength(window.left, beyond);
  const Vector2 place = window.placeBeyond(from_right, from_left);
  const double of_right = window.beside(window.right_ray, place);
  const double of_left = window.beside(window.left_ray, place);
  const double aside = WINDOW_ASIDE * WINDOW_ASIDE * window.squaredDistance(place);
  if (of_right > 0.0) {
    if (of_left < 0.0) {
      return split(window, beyond, place, from_right, from_left);
    }
    if (of_left * of_left <= aside) {
      offer(beyond, window, place);
    }
    window.turnRight(beyond, place, from_right);
    return goesOn(window);
  }
  const bool is_reached = of_right * of_right <= aside;
  if (of_left < 0.0) {
    if (is_reached) {
      offer(beyond, window, place);
    }
    window.turnLeft(beyond, place, from_left);
    return goesOn(window);
  }
  if (is_reached && of_left * of_left <= aside) {
    offer(beyond, window, place);
  }
  return false;
}

/// To both sides of the third corner, which it reaches.
bool WindowPropagation::split(Window& window, std::uint32_t beyond, const Vector2& place,
                              double from_right, double from_left)
{
  offer(beyond, window, place);
  const double distance = window.distance(place);
  const Vector2 ray = window.rayTo(place);
  Window part = window;
  part.turnLeft(beyond, place, from_left);
  part.right_ray = ray;
  if (!part.isEmpty(WINDOW_WIDTH, distance) && goesOn(part)) {
    next_.push_back(part);
  }
  window.turnRight(beyond, place, from_right);
  window.left_ray = ray;
  return !window.isEmpty(WINDOW_WIDTH, distance) && goesOn(window);
}

/// Can anything come of it?
bool WindowPropagation::goesOn(Window& window) const
{
  const double by_right = known(window.right), by_left = known(window.left);
  if (by_right + by_left == 0.0) {
    return false;  // lethal ones: whatever is behind starts there
  }
  const double length = std::sqrt(window.length);
  const double even = 0.5 * (1.0 + (by_left - by_right) * length * window.inverse);
  const Doubles2 range = window.range(), wanted = {window.nearestPart(), even};
  const Doubles2 parts = minimum(maximum(wanted, Doubles2{range[0], range[0]}),
                                 Doubles2{range[1], range[1]});  // the first, if it is no number
  const Doubles2 squared = window.squaredDistances(parts);
  const double nearest = squared[0], reach = max_distance_ - window.offset;
  if (!(nearest <= reach * reach)) {
    return false;
  }
  // Along the edge from a point of it to its ends, other ways become no better than this one where
  // they are not so at the point: it is enough to look where both ends are equally good.
  const double other = std::min(by_right + parts[1] * length, by_left + (1.0 - parts[1]) * length);
  const double least = other * (1.0 + LONGER) - window.offset;
  if (least < 0.0 || squared[1] > least * least) {
    return false;
  }
  if (window.may_leave &&
      !canReach(window.right, window.left, length, window.offset + std::sqrt(nearest))) {
    return false;
  }
  window.standing = nearest > window.nearest ? 0 : window.standing + 1;
  if (window.standing > MOST_STANDING &&
      window.standing > mesh_.corners(window.right).size() + mesh_.corners(window.left).size()) {
    return false;  // round and round among faces without area; around a vertex it can go but once
  }
  window.nearest = nearest;
  return true;
}

void WindowPropagation::queue(const Window& window)
{
  auto place = static_cast<std::uint32_t>(windows_.size());
  if (free_.empty()) {
    windows_.push_back(window);
  } else {
    place = free_.back();
    free_.pop_back();
    windows_[place] = window;
  }
  const double nearest = window.offset + std::sqrt(window.nearest);
  queue_.push(static_cast<float>(nearest * (1.0 - EARLIER)) * (1.0f - 1.2e-7f), place);
}

/// Can a way that goes this far from an edge come to where distances are wanted? The bound is
/// Lipschitz, so along the edge it is at least half of what those of its ends exceed its length by.
bool WindowPropagation::canReach(std::uint32_t a, std::uint32_t b, double length,
                                 double distance) const
{
  const double least = 0.5 * (gap(a) + gap(b) - length);
  return least <= 0.0 || distance + least <= max_distance_ * (1.0 + LONGER);
}

void WindowPropagation::offer(std::uint32_t v, const Window& window, const Vector2& place)
{
  const double length = window.offset + window.distance(place);
  const auto distance =
      std::max(std::numeric_limits<float>::denorm_min(), static_cast<float>(length));
  if (!(distance <= max_distance_) || distance > distanceOf(labels_[v])) {
    return;
  }
  const double along = window.crossing(place);
  const ArrayView<FastMarchingCorner> row = mesh_.corners(v);
  for (std::uint32_t i = 0; i < row.size(); ++i) {
    const bool is_same = row[i].a == window.right && row[i].b == window.left;
    if (is_same || (row[i].a == window.left && row[i].b == window.right)) {
      take(v, distance, PathStart::pack(row.size(), i, is_same ? along : 1.0 - along));
      return;
    }
  }
}

void WindowPropagation::take(std::uint32_t v, float distance, std::uint32_t start)
{
  const WindowLabel label = labelOf(distance, start), before = labels_[v];
  if (label < before) {
    labels_[v] = label;
    if (before == NO_LABEL) {
      reached_.push_back(v);
    }
    if (distance < distanceOf(before) && !is_starting_) {
      queue_.push(distance, VERTEX | v);
    }
  }
}

}  // namespace mesh_map
