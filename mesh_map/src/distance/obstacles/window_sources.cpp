#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "distance/obstacles/window_propagation.h"
#include "mesh/packed_position.h"

namespace mesh_map {
namespace {

/// Of directions of length 1: at the angle of one less that of another.
Vector2 turnedBack(const Vector2& a, const Vector2& b)
{
  return {a[0] * b[0] + a[1] * b[1], a[1] * b[0] - a[0] * b[1]};
}

/// The angle between two vectors as a direction; none where one has no length.
Vector2 turnBetween(const Vector3& a, const Vector3& b)
{
  const double cosine = dot(a, b);
  const Vector3 normal = cross(a, b);
  const double squared = dot(normal, normal), size = std::sqrt(cosine * cosine + squared);
  return size > 0.0 ? Vector2{cosine / size, std::sqrt(squared) / size} : Vector2{1.0, 0.0};
}

/// Is the right one of two limits to the right of the left one by enough? Both within half a turn.
bool isOpen(const Vector2& right, const Vector2& left)
{
  const double sine = cross(right, left);
  return sine > WINDOW_WIDTH || (sine > 0.0 && dot(right, left) < 0.0);
}

}  // namespace

/// Do ways from a vertex with this distance come to where no distances are wanted?
bool WindowPropagation::mayLeave(std::uint32_t v, double offset) const
{
  if (scope_.gaps != nullptr) {
    return true;
  }
  const double at = scope_.at(mesh_.position(v));
  const double reach = max_distance_ - offset;
  return !(at - scope_.low > reach && scope_.high - at > reach);
}

/// What lethal vertices send out. What is along edges comes first: it is found at once, and ends
/// most of the windows that are no good.
void WindowPropagation::start(ArrayView<std::uint32_t> obstacles)
{
  starts_.clear();
  forEachFetched(obstacles, [this](std::uint32_t v) {
    if (isInScope(v)) {
      starts_.push_back(v);
      offerAlongEdges(v, 0.0);
    }
  });
  forEachFetched({starts_.data(), starts_.size()}, [this](std::uint32_t v) { startStrips(v); });
  forEachFetched({starts_.data(), starts_.size()}, [this](std::uint32_t v) { startCones(v, 0.0); });
}

/// From the edges between a lethal vertex and others with larger indices into faces with a third
/// corner that is not lethal.
void WindowPropagation::startStrips(std::uint32_t v)
{
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
  Window window{};
  window.right = right;
  window.left = left;
  window.is_strip = true;
  window.may_leave = mayLeave(right, 0.0) || mayLeave(left, 0.0);
  window.length = squaredLength(right, left);
  window.inverse = 1.0 / window.length;
  window.right_end = window.right_ray = {std::sqrt(window.length), 0.0};
  window.left_end = window.left_ray = {0.0, 0.0};
  if (enter(window, beyond)) {
    next_.push_back(window);
  }
  follow();
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

/// The way along the edge from a vertex with this distance.
void WindowPropagation::offerAlong(std::uint32_t from, std::uint32_t v, double distance)
{
  const double room = known(v) - distance;
  if (!(room > 0.0)) {
    return;
  }
  const double squared = squaredLength(from, v);
  if (squared > room * room * (1.0 + 1e-6) || v == from || lethal_[v] != 0) {
    return;
  }
  const double length = distance + std::sqrt(squared);
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
    const Vector2 turn = turnBetween(between(mesh_.position(v), mesh_.position(corner.a)),
                                     between(mesh_.position(v), mesh_.position(corner.b)));
    startCone(v, offset, corner, turn, {1.0, 0.0}, turn);
  }
}

/// Only where no other way is shorter: at right angles or more from edges to other lethal vertices,
/// or at half a turn or more from where the way comes in.
void WindowPropagation::startConesOfFan(std::uint32_t v, double offset)
{
  const ArrayView<FastMarchingCorner> row = mesh_.corners(v);
  const std::size_t count = row.size();
  const bool is_closed = mesh_.isClosed(v);
  if (lethal_[v] == 0) {
    const PathStart start = PathStart::unpack(count, static_cast<std::uint32_t>(labels_[v]));
    const std::size_t corner = start.corner;
    const Vector3 a = between(mesh_.position(v), mesh_.position(row[corner].a));
    const Vector3 b = between(mesh_.position(v), mesh_.position(row[corner].b));
    const Vector3 crossing = a + start.along * (b - a);
    const double unsure = start.step * norm(b - a) / norm(crossing);  // long edges, near by
    const double aside = std::min(0.5 * PI, unsure + WINDOW_ASIDE);
    const Vector2 clear = {-std::cos(aside), std::sin(aside)};
    const Vector2 right = turnedBack(clear, turnBetween(crossing, b));
    const Vector2 left = turnedBack(clear, turnBetween(a, crossing));
    if (is_closed) {
      startConesBetween(v, offset, corner + 1, corner + count, &right, &left);
    } else {
      startConesBetween(v, offset, corner + 1, count, &right, nullptr);
      startConesBetween(v, offset, 0, corner, nullptr, &left);
    }
    return;
  }
  const auto isLethal = [&](std::size_t spoke) {
    return lethal_[spoke < count ? row[spoke].a
                   : is_closed   ? row[spoke - count].a
                                 : row[count - 1].b] != 0;
  };
  const Vector2 clear = {WINDOW_ASIDE, 1.0};
  std::size_t begin = 0;
  while (is_closed && begin < count && !isLethal(begin)) {
    ++begin;
  }
  if (begin == count) {
    startConesBetween(v, offset, 0, count, nullptr, nullptr);
    return;
  }
  for (std::size_t from = begin; from < begin + count;) {
    std::size_t to = from + 1;
    while (to < begin + count && !isLethal(to)) {
      ++to;
    }
    startConesBetween(v, offset, from, to, isLethal(from) ? &clear : nullptr,
                      isLethal(to) ? &clear : nullptr);
    from = to;
  }
}

/// Into the corners of a fan from one to before another one (counted on where it is closed), to the
/// left of a limit, seen from the first edge, and to the right of one, seen to the right of the
/// last edge.
void WindowPropagation::startConesBetween(std::uint32_t v, double offset, std::size_t from,
                                          std::size_t to, const Vector2* right, const Vector2* left)
{
  const ArrayView<FastMarchingCorner> row = mesh_.corners(v);
  if (to == from + 1 && lethal_[row[from % row.size()].a] != 0 &&
      lethal_[row[from % row.size()].b] != 0) {
    return;
  }
  constexpr Vector2 AHEAD = {1.0, 0.0};
  sectors_.clear();
  Vector2 limit = right != nullptr ? *right : AHEAD;
  bool is_past = right == nullptr || limit[1] < 0.0;
  for (std::size_t i = from; i < to; ++i) {
    const FastMarchingCorner& corner = row[i < row.size() ? i : i - row.size()];
    const Vector3 a = between(mesh_.position(v), mesh_.position(corner.a));
    const Vector3 b = between(mesh_.position(v), mesh_.position(corner.b));
    Sector sector{corner, turnBetween(a, b), AHEAD, !is_past};
    if (!is_past) {
      is_past = cross(sector.turn, limit) < 0.0;
      sector.is_hidden = !is_past;
      sector.right = limit;
      limit = turnedBack(limit, sector.turn);
    }
    sectors_.push_back(sector);
  }
  limit = left != nullptr ? *left : AHEAD;
  is_past = left == nullptr || limit[1] < 0.0;
  while (!sectors_.empty()) {
    const Sector sector = sectors_.back();
    sectors_.pop_back();
    if (sector.is_hidden) {
      return;
    }
    Vector2 to_left = sector.turn;
    if (!is_past) {
      is_past = cross(sector.turn, limit) < 0.0;
      to_left = turnedBack(sector.turn, limit);
      limit = turnedBack(limit, sector.turn);
      if (!is_past) {
        continue;
      }
    }
    if (isOpen(sector.right, to_left) &&
        (lethal_[sector.corner.a] == 0 || lethal_[sector.corner.b] == 0)) {
      startCone(v, offset, sector.corner, sector.turn, sector.right, to_left);
    }
  }
}

/// Into the face of a corner with this angle between two limits: a is to the right.
void WindowPropagation::startCone(std::uint32_t v, double offset, const FastMarchingCorner& corner,
                                  const Vector2& turn, const Vector2& right_ray,
                                  const Vector2& left_ray)
{
  const double a = std::sqrt(squaredLength(v, corner.a)), b = std::sqrt(squaredLength(v, corner.b));
  if (a > 0.0 && b > 0.0) {
    Window window{};
    window.right = corner.a;
    window.left = corner.b;
    window.from = v;
    window.may_leave = mayLeave(v, offset);
    window.offset = offset;
    window.length = squaredLength(corner.a, corner.b);
    window.inverse = 1.0 / window.length;
    window.right_end = {a, 0.0};
    window.left_end = b * turn;
    window.right_ray = right_ray;
    window.left_ray = left_ray;
    if (goesOn(window)) {
      next_.push_back(window);
    }
    follow();
  }
}

}  // namespace mesh_map
