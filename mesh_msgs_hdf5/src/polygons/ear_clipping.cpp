#include "polygons/ear_clipping.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace mesh_msgs_hdf5 {
namespace {
constexpr std::size_t NONE = std::numeric_limits<std::size_t>::max();
// of the sum of both products: beyond it their difference has the right sign
constexpr double ROUNDING = 1e-15;

double squaredLength(const Point& p, const Point& q)
{
  return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y);
}

struct Edge
{
  Point from;
  Point to;
  double low;
  double high;
};

bool areCrossing(const Edge& e, const Edge& f)
{
  if (std::max(e.from.y, e.to.y) < std::min(f.from.y, f.to.y) ||
      std::max(f.from.y, f.to.y) < std::min(e.from.y, e.to.y)) {
    return false;
  }
  return turn(e.from, e.to, f.from) * turn(e.from, e.to, f.to) < 0 &&
         turn(f.from, f.to, e.from) * turn(f.from, f.to, e.to) < 0;
}
}  // namespace

double turn(const Point& a, const Point& b, const Point& c)
{
  const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
  const double left = bx * cy, right = by * cx;
  const double difference = left - right;
  if (std::abs(difference) > ROUNDING * (std::abs(left) + std::abs(right))) {
    return difference;
  }
  // what both products lost by rounding
  return difference + (std::fma(bx, cy, -left) - std::fma(by, cx, -right));
}

bool crossesItself(const std::vector<Point>& polygon, std::int64_t& steps)
{
  std::vector<Edge> edges;
  edges.reserve(polygon.size());
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    edges.push_back({p, q, std::min(p.x, q.x), std::max(p.x, q.x)});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& e, const Edge& f) { return e.low < f.low; });
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size() && edges[j].low <= edges[i].high; ++j) {
      if (--steps < 0) {
        return false;
      }
      if (areCrossing(edges[i], edges[j])) {
        return true;
      }
    }
  }
  return false;
}

EarClipping::EarClipping(const std::vector<Point>& polygon, std::int64_t& steps)
    : points_(polygon),
      steps_(steps),
      before_(polygon.size()),
      behind_(polygon.size()),
      versions_(polygon.size(), 0),
      left_(polygon.size())
{
  for (std::size_t i = 0; i < left_; ++i) {
    before_[i] = (i + left_ - 1) % left_;
    behind_[i] = (i + 1) % left_;
  }
}

double EarClipping::turnAt(std::size_t corner) const
{
  return turn(points_[before_[corner]], points_[corner], points_[behind_[corner]]);
}

/// Whether the way comes back along itself at this corner, or the corner comes twice.
bool EarClipping::isSpike(std::size_t corner) const
{
  const Point &a = points_[before_[corner]], &b = points_[corner], &c = points_[behind_[corner]];
  return turn(a, b, c) == 0 &&
         (a == b || b == c || (a.x - b.x) * (c.x - b.x) + (a.y - b.y) * (c.y - b.y) > 0);
}

/// From 0, a needle, to 1, a square's half.
double EarClipping::quality(std::size_t corner) const
{
  const Point &a = points_[before_[corner]], &b = points_[corner], &c = points_[behind_[corner]];
  const double longest = std::max({squaredLength(a, b), squaredLength(b, c), squaredLength(c, a)});
  return longest > 0 ? 2 * turn(a, b, c) / longest : 0;
}

/// Whether the way from a corner on the border of an ear to the next one begins inside of the ear.
/// sides: of the corner, 0 where it lies on that side.
bool EarClipping::enters(const std::array<Point, 3>& ear, const std::array<double, 3>& sides,
                         std::size_t to) const
{
  for (std::size_t i = 0; i < 3; ++i) {
    if (sides[i] == 0 && !(turn(ear[i], ear[(i + 1) % 3], points_[to]) > 0)) {
      return false;
    }
  }
  return true;
}

EarClipping::Ear EarClipping::look(std::size_t corner)
{
  const std::array<Point, 3> ear{points_[before_[corner]], points_[corner],
                                 points_[behind_[corner]]};
  const auto [left, right] = std::minmax({ear[0].x, ear[1].x, ear[2].x});
  const auto [low, high] = std::minmax({ear[0].y, ear[1].y, ear[2].y});
  Ear result = Ear::FREE;
  for (std::size_t i = behind_[behind_[corner]]; i != before_[corner]; i = behind_[i]) {
    --steps_;
    const Point& p = points_[i];
    if (p.x < left || p.x > right || p.y < low || p.y > high) {
      continue;
    }
    const std::array<double, 3> sides{turn(ear[0], ear[1], p), turn(ear[1], ear[2], p),
                                      turn(ear[2], ear[0], p)};
    const double least = std::min({sides[0], sides[1], sides[2]});
    if (least < 0) {
      continue;
    }
    if (least > 0 || enters(ear, sides, before_[i]) || enters(ear, sides, behind_[i])) {
      return Ear::BLOCKED;
    }
    if (sides[2] == 0 && !(p == ear[0]) && !(p == ear[2])) {
      result = Ear::TOUCHED;
    }
  }
  return result;
}

/// Puts a corner among the candidates if it may be an ear.
void EarClipping::offer(std::size_t corner)
{
  ++versions_[corner];
  const bool spike = isSpike(corner);
  if (spike || turnAt(corner) > 0) {
    const double good = spike ? std::numeric_limits<double>::infinity() : quality(corner);
    heap_.push_back({good, corner, versions_[corner]});
    std::push_heap(heap_.begin(), heap_.end());
  }
}

void EarClipping::clip(std::size_t corner, std::vector<Corners>& triangles)
{
  const std::size_t a = before_[corner], c = behind_[corner];
  triangles.push_back({static_cast<std::int64_t>(a), static_cast<std::int64_t>(corner),
                       static_cast<std::int64_t>(c)});
  sound_ = sound_ && turnAt(corner) >= 0;
  behind_[a] = c;
  before_[c] = a;
  ++versions_[corner];
  any_ = a;
  --left_;
  offer(a);
  offer(c);
}

/// The corner to clip where no candidate is an ear.
std::size_t EarClipping::nextBest()
{
  // from best to worst: an ear, maybe one that is touched; one in a straight line; one that is no
  // ear; any
  std::array<std::size_t, 4> found;
  found.fill(NONE);
  double best = -1, best_blocked = -1;
  std::size_t i = any_;
  for (std::size_t n = 0; n < left_; ++n, i = behind_[i]) {
    const double at = turnAt(i), good = quality(i);
    if (at > 0 && good > best && steps_ > 0 && look(i) != Ear::BLOCKED) {
      best = good;
      found[0] = i;
    } else if (at > 0 && good > best_blocked) {
      best_blocked = good;
      found[2] = i;
    } else if (at == 0) {
      found[1] = i;
    }
  }
  found[3] = any_;
  const std::size_t kind = found[0] != NONE ? 0 : found[1] != NONE ? 1 : found[2] != NONE ? 2 : 3;
  sound_ = sound_ && kind < 2;
  return found[kind];
}

bool EarClipping::run(std::vector<Corners>& triangles)
{
  for (std::size_t i = 0; i < left_; ++i) {
    offer(i);
  }
  while (left_ > 3) {
    if (heap_.empty()) {
      clip(nextBest(), triangles);
      continue;
    }
    std::pop_heap(heap_.begin(), heap_.end());
    const Candidate candidate = heap_.back();
    heap_.pop_back();
    if (candidate.version != versions_[candidate.corner]) {
      continue;
    }
    if (steps_ <= 0) {
      sound_ = false;
      clip(candidate.corner, triangles);
    } else if (std::isinf(candidate.quality) || look(candidate.corner) == Ear::FREE) {
      clip(candidate.corner, triangles);
    }
  }
  if (left_ == 3) {
    clip(any_, triangles);
  }
  return sound_;
}

}  // namespace mesh_msgs_hdf5
