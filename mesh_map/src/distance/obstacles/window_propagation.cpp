#include "distance/obstacles/window_propagation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/unique.h"
#include "mesh/packed_position.h"

namespace mesh_map {
namespace {

/// A vertex as far as this (radians) aside of a window is reached by it: more than what is narrower
/// than WIDTH or lies behind a vertex with less than BEND above a full turn is hidden.
constexpr double ASIDE = 4e-6;
constexpr double WIDTH = 1e-6;

/// How much longer a way has to be than another one (by this part of it) to count as longer:
/// above the rounding of labels, so that no best way ever ends.
constexpr double LONGER = 1e-6;

/// Windows are queued at least this part before what they can offer.
constexpr double EARLIER = 1e-9;

/// A window goes on by itself this many edges: that is cheaper than to queue it for each.
constexpr double AHEAD = 16.0;

constexpr std::uint32_t MOST_STANDING = 1024;

/// Among so few corners a face is found at once.
constexpr std::size_t SHORT_ROW = 12;

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
  unsigned bits = 31;
  while (bits > 0 && (corners - 1) >> (32 - bits) != 0) {
    --bits;
  }
  return bits;
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
    if (isInScope(v)) {
      start(v);
    }
  }
  DistanceEntry entry;
  for (std::uint32_t steps = 1; queue_.pop(entry); ++steps) {
    if (entry.vertex >= VERTEX) {
      const std::uint32_t v = entry.vertex - VERTEX;
      if (entry.distance == distanceOf(labels_[v])) {
        leaveVertex(v);
      }
    } else {
      const Window window = windows_[entry.vertex];
      free_.push_back(entry.vertex);
      cross(window);
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

/// What a lethal vertex sends out: along edges, as a point, and as an end of edges.
void WindowPropagation::start(std::uint32_t v)
{
  bool is_next_to_free = false, is_next_to_lethal = false;
  for (const FastMarchingCorner& corner : mesh_.corners(v)) {
    for (const std::uint32_t u : {corner.a, corner.b}) {
      is_next_to_free = is_next_to_free || lethal_[u] == 0;
      is_next_to_lethal = is_next_to_lethal || (lethal_[u] != 0 && u != v);
    }
  }
  if (!is_next_to_free) {
    return;
  }
  offerAlongEdges(v, 0.0);
  startCones(v, 0.0);
  if (!is_next_to_lethal) {
    return;
  }
  for (const FastMarchingCorner& corner : mesh_.corners(v)) {
    if (corner.a == corner.b || (lethal_[corner.a] != 0) == (lethal_[corner.b] != 0)) {
      continue;
    }
    const std::uint32_t other = lethal_[corner.a] != 0 ? corner.a : corner.b;
    if (v < other) {
      startStrip(v, other, lethal_[corner.a] != 0 ? corner.b : corner.a);
    }
  }
}

/// From the edge between two lethal vertices into a face with a third one.
void WindowPropagation::startStrip(std::uint32_t right, std::uint32_t left, std::uint32_t beyond)
{
  const double length = std::sqrt(squaredLength(right, left));
  if (length > 0.0) {
    Window window{};
    window.right = right;
    window.left = left;
    window.is_strip = true;
    window.right_end = window.right_ray = {length, 0.0};
    window.left_end = window.left_ray = {0.0, 0.0};
    enter(window, beyond);
    queueNext();
  }
}

void WindowPropagation::leaveVertex(std::uint32_t v)
{
  const double distance = distanceOf(labels_[v]);
  offerAlongEdges(v, distance);
  if (!mesh_.isClosed(v) || mesh_.isSaddle(v)) {
    startCones(v, distance);
  }
}

void WindowPropagation::offerAlongEdges(std::uint32_t v, double distance)
{
  const bool is_fan = mesh_.isFan(v), is_closed = mesh_.isClosed(v);
  for (const FastMarchingCorner& corner : mesh_.corners(v)) {
    offerAlong(v, corner.a, distance);
    if (!is_closed || !is_fan) {
      offerAlong(v, corner.b, distance);
    }
  }
}

/// Windows from a vertex, a lethal one or one where ways bend, into all faces around it.
void WindowPropagation::startCones(std::uint32_t v, double offset)
{
  if (mesh_.isFan(v)) {
    startConesOfFan(v, offset);
    return;
  }
  const ArrayView<FastMarchingCorner> row = mesh_.corners(v);
  std::vector<FastMarchingCorner> corners;
  for (const FastMarchingCorner& corner : row) {
    if (corner.a != corner.b) {
      corners.push_back({std::min(corner.a, corner.b), std::max(corner.a, corner.b)});
    }
  }
  const auto isBefore = [](const FastMarchingCorner& p, const FastMarchingCorner& q) {
    return std::tie(p.a, p.b) < std::tie(q.a, q.b);
  };
  const auto isSame = [](const FastMarchingCorner& p, const FastMarchingCorner& q) {
    return p.a == q.a && p.b == q.b;
  };
  std::sort(corners.begin(), corners.end(), isBefore);
  corners.erase(std::unique(corners.begin(), corners.end(), isSame), corners.end());
  for (const FastMarchingCorner& corner : corners) {
    const Vector3 a = between(mesh_.position(v), mesh_.position(corner.a));
    const Vector3 b = between(mesh_.position(v), mesh_.position(corner.b));
    const double cosine = dot(a, b), sine = norm(mesh_map::cross(a, b));
    const double length = std::hypot(cosine, sine);
    if (length > 0.0) {
      startCone(v, offset, corner, cosine / length, sine / length, {1.0, 0.0},
                {cosine / length, sine / length});
    }
  }
}

/// Only where no other way is shorter: at right angles or more from edges to other lethal vertices,
/// or at half a turn or more from where the way comes in.
void WindowPropagation::startConesOfFan(std::uint32_t v, double offset)
{
  const ArrayView<FastMarchingCorner> row = mesh_.corners(v);
  const std::size_t count = row.size();
  const bool is_closed = mesh_.isClosed(v);
  angles_.assign(1, 0.0);
  for (const FastMarchingCorner& corner : row) {
    const Vector3 a = between(mesh_.position(v), mesh_.position(corner.a));
    const Vector3 b = between(mesh_.position(v), mesh_.position(corner.b));
    angles_.push_back(angles_.back() + angleBetween(a, b));
  }
  const double turn = angles_.back();
  spokes_.clear();
  if (lethal_[v] != 0) {
    for (std::size_t i = 0; i < count; ++i) {
      if (lethal_[row[i].a] != 0) {
        spokes_.push_back({angles_[i], 0.5 * PI});
      }
    }
    if (!is_closed && lethal_[row[count - 1].b] != 0) {
      spokes_.push_back({turn, 0.5 * PI});
    }
  } else {
    const PathStart start = PathStart::unpack(count, static_cast<std::uint32_t>(labels_[v]));
    const FastMarchingCorner& corner = row[start.corner];
    const Vector3 a = between(mesh_.position(v), mesh_.position(corner.a));
    const Vector3 b = between(mesh_.position(v), mesh_.position(corner.b));
    const Vector3 crossing = a + start.along * (b - a);
    const double unsure = start.step * norm(b - a) / norm(crossing);  // long edges, near by
    spokes_.push_back({angles_[start.corner] + angleBetween(a, crossing), PI - unsure});
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (lethal_[row[i].a] != 0 && lethal_[row[i].b] != 0) {
      continue;
    }
    double low = angles_[i], high = angles_[i + 1];
    for (const Spoke& spoke : spokes_) {
      for (const double shift : {-turn, 0.0, turn}) {
        if (shift != 0.0 && !is_closed) {
          continue;
        }
        const double begin = spoke.angle + shift - spoke.clearance + ASIDE;
        const double end = spoke.angle + shift + spoke.clearance - ASIDE;
        if (begin <= low && low < end) {
          low = end;
        }
        if (begin < high && high <= end) {
          high = begin;
        }
      }
    }
    if (high - low > WIDTH) {
      const double corner = angles_[i + 1] - angles_[i];
      const double r = low - angles_[i], l = high - angles_[i];
      startCone(v, offset, row[i], std::cos(corner), std::sin(corner), {std::cos(r), std::sin(r)},
                {std::cos(l), std::sin(l)});
    }
  }
}

/// Into the face of a corner with this angle between two limits: a is to the right.
void WindowPropagation::startCone(std::uint32_t v, double offset, const FastMarchingCorner& corner,
                                  double cosine, double sine, const Vector2& right_ray,
                                  const Vector2& left_ray)
{
  const double a = std::sqrt(squaredLength(v, corner.a)), b = std::sqrt(squaredLength(v, corner.b));
  if (a > 0.0 && b > 0.0) {
    consider({corner.a,
              corner.b,
              v,
              false,
              0,
              offset,
              0.0,
              {a, 0.0},
              {b * cosine, b * sine},
              right_ray,
              left_ray});
    queueNext();
  }
}

/// Into all other faces at its edge, and on to the next ones, as long as it stays one and does not
/// come far ahead of the others.
void WindowPropagation::cross(const Window& first)
{
  Window window = first;
  const double ahead = window.nearest + AHEAD * mesh_.meanEdge();
  while (true) {
    const std::size_t row = mesh_.corners(window.right).size();
    const bool is_right = row <= SHORT_ROW || row <= mesh_.corners(window.left).size();
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
    if (beyond_.size() > 1) {
      makeUnique(beyond_);
    }
    next_.clear();
    if (beyond_.size() > 1 && !(isFirstOfItsKind(window) && isBestSomewhere(window))) {
      return;
    }
    for (const std::uint32_t third : beyond_) {
      enter(window, third);
    }
    if (next_.size() != 1 || next_.front().nearest > ahead) {
      break;
    }
    window = next_.front();
  }
  queueNext();
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

/// Into the face with this third corner, and to its two other edges.
void WindowPropagation::enter(const Window& window, std::uint32_t beyond)
{
  Vector2 place;
  if (!placeBeyond(window.right_end, window.left_end, squaredLength(window.right, beyond),
                   squaredLength(window.left, beyond), place)) {
    return;
  }
  const double of_right = window.beside(window.right_ray, place);
  const double of_left = window.beside(window.left_ray, place);
  const double aside = ASIDE * window.distance(place);
  if (of_right >= -aside && of_left <= aside) {
    offer(beyond, window, place);
  }
  if (of_right > 0.0) {
    consider(window.part(window.right, beyond, window.left, window.right_end, place,
                         window.right_ray, of_left <= 0.0 ? window.rayTo(place) : window.left_ray));
  }
  if (of_left < 0.0) {
    consider(window.part(beyond, window.left, window.right, place, window.left_end,
                         of_right >= 0.0 ? window.rayTo(place) : window.right_ray,
                         window.left_ray));
  }
}

/// Is next, unless nothing can come of it.
void WindowPropagation::consider(Window child)
{
  if (lethal_[child.right] != 0 && lethal_[child.left] != 0) {
    return;  // whatever is behind starts there
  }
  const Vector2& a = child.right_end;
  const Vector2& b = child.left_end;
  const auto [from, to] = child.range();
  const Vector2 edge = b - a;
  const double nearest = child.offset + child.nearestBetween(a + from * edge, a + to * edge);
  if (!(nearest <= max_distance_) || child.isEmpty(WIDTH, nearest)) {
    return;
  }
  // Along the edge from a point of it to a, and to b, other ways become no better than this one
  // where they are not so at the point: it is enough to look where both ends are equally good.
  const double length = norm(edge), by_a = known(child.right), by_b = known(child.left);
  const double even = std::isfinite(by_a) && std::isfinite(by_b)
                          ? std::min(to, std::max(from, 0.5 * (1.0 + (by_b - by_a) / length)))
                      : std::isfinite(by_a) ? to
                                            : from;
  if (std::min(by_a + even * length, by_b + (1.0 - even) * length) <
      (child.offset + child.distance(a + even * edge)) * (1.0 - LONGER)) {
    return;
  }
  if (!canReach(child.right, child.left, length, nearest)) {
    return;
  }
  child.standing = nearest > child.nearest ? 0 : child.standing + 1;
  if (child.standing > MOST_STANDING &&
      child.standing > mesh_.corners(child.right).size() + mesh_.corners(child.left).size()) {
    return;  // round and round among faces without area; around a vertex it can go but once
  }
  child.nearest = nearest;
  next_.push_back(child);
}

void WindowPropagation::queueNext()
{
  for (const Window& window : next_) {
    auto place = static_cast<std::uint32_t>(windows_.size());
    if (free_.empty()) {
      windows_.push_back(window);
    } else {
      place = free_.back();
      free_.pop_back();
      windows_[place] = window;
    }
    queue_.push(static_cast<float>(window.nearest * (1.0 - EARLIER)) * (1.0f - 1.2e-7f), place);
  }
  next_.clear();
}

/// Can a way that goes this far from an edge come to where distances are wanted? The bound is
/// Lipschitz, so along the edge it is at least half of what those of its ends exceed its length by.
bool WindowPropagation::canReach(std::uint32_t a, std::uint32_t b, double length,
                                 double distance) const
{
  if (is_all_in_scope_) {
    return true;
  }
  const double least = 0.5 * (gap(a) + gap(b) - length);
  return distance + std::max(0.0, least) <= max_distance_ * (1.0 + LONGER);
}

void WindowPropagation::offer(std::uint32_t v, const Window& window, const Vector2& place)
{
  const double length = window.offset + window.distance(place);
  const auto distance =
      std::max(std::numeric_limits<float>::denorm_min(), static_cast<float>(length));
  if (lethal_[v] != 0 || !(distance <= max_distance_) || distance > distanceOf(labels_[v])) {
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

/// The way along the edge from a vertex with this distance.
void WindowPropagation::offerAlong(std::uint32_t from, std::uint32_t v, double distance)
{
  if (v == from || lethal_[v] != 0) {
    return;
  }
  const double length = distance + std::sqrt(squaredLength(from, v));
  const auto rounded =
      std::max(std::numeric_limits<float>::denorm_min(), static_cast<float>(length));
  if (!(rounded <= max_distance_) || rounded > distanceOf(labels_[v])) {
    return;
  }
  const ArrayView<FastMarchingCorner> row = mesh_.corners(v);
  for (std::uint32_t i = 0; i < row.size(); ++i) {
    if (row[i].a == from || row[i].b == from) {
      take(v, rounded, PathStart::pack(row.size(), i, row[i].a == from ? 0.0 : 1.0));
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
    if (distance < distanceOf(before)) {
      queue_.push(distance, VERTEX | v);
    }
  }
}

}  // namespace mesh_map
