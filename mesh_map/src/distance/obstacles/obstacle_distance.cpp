#include "distance/obstacles/obstacle_distance.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "base/require.h"
#include "distance/obstacles/near_changes.h"
#include "mesh/packed_position.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

/// Parts of the mesh, and the slabs that threads solve, are at least this many times as wide as the
/// maximum distance: what is that near to two slabs is solved with both.
constexpr double PART_WIDTH = 16.0;

/// Few, since each costs what is near to its ends; more than one, so that threads come to an end at
/// about the same time.
constexpr std::size_t SLABS_PER_THREAD = 2;
/// In a slab, about: between them it is seen at the latest that it was canceled.
constexpr std::size_t MOST_OBSTACLES = 16384;

/// Where one of two rows of flags is set, and the other one is not: ascending.
std::vector<std::uint32_t> differences(ArrayView<std::uint8_t> one,
                                       const std::vector<std::uint8_t>& other)
{
  std::vector<std::uint32_t> found;
  constexpr std::size_t AT_A_TIME = 64;
  for (std::size_t begin = 0; begin < one.size(); begin += AT_A_TIME) {
    const std::size_t end = std::min(begin + AT_A_TIME, one.size());
    if (std::memcmp(one.data() + begin, other.data() + begin, end - begin) == 0) {
      continue;
    }
    for (std::size_t v = begin; v < end; ++v) {
      if ((one[v] != 0) != (other[v] != 0)) {
        found.push_back(static_cast<std::uint32_t>(v));
      }
    }
  }
  return found;
}

}  // namespace

ObstacleDistance::ObstacleDistance(std::shared_ptr<const FastMarchingMesh> mesh, float max_distance)
    : mesh_(std::move(mesh)),
      max_distance_(max_distance),
      lethal_(mesh_->vertexCount()),
      distance_(mesh_->vertexCount(), INFINITE),
      start_(mesh_->vertexCount(), 0),
      parts_(*mesh_, PART_WIDTH * max_distance)
{
  require(max_distance > 0.0f, "the maximum distance has to be above 0");
}

bool ObstacleDistance::compute(ArrayView<std::uint8_t> lethal, const std::atomic<bool>* cancel,
                               unsigned threads)
{
  require(lethal.size() == lethal_.size(), "there have to be as many lethal flags as vertices");
  known_ = false;  // until it ends
  lethal_.assign(lethal.begin(), lethal.end());
  const std::vector<Slab> wanted = slabs(clear(threads), resolveThreads(threads));
  std::atomic<bool> is_done{true};
  parallelFor(wanted.size(), 1, threads, [&]() -> RangeBody {
    const auto propagation = std::make_shared<WindowPropagation>(*mesh_, max_distance_);
    return [&, propagation](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && is_done; ++i) {
        if (!solveIn(wanted, i, *propagation, cancel)) {
          is_done = false;
        }
      }
    };
  });
  known_ = is_done;
  return known_;
}

/// Forgets all distances, and finds the borders of obstacles.
std::vector<std::uint32_t> ObstacleDistance::clear(unsigned threads)
{
  constexpr std::size_t AT_A_TIME = 16384;
  std::vector<std::vector<std::uint32_t>> found((lethal_.size() + AT_A_TIME - 1) / AT_A_TIME);
  std::vector<double> longest(found.size());
  parallelFor(lethal_.size(), AT_A_TIME, threads, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      const std::size_t chunk = begin / AT_A_TIME;
      for (std::size_t v = begin; v < end; ++v) {
        distance_[v] = lethal_[v] != 0 ? 0.0f : INFINITE;
        start_[v] = 0;
        if (lethal_[v] != 0 && isAtBorder(static_cast<std::uint32_t>(v))) {
          found[chunk].push_back(static_cast<std::uint32_t>(v));
          longest[chunk] = std::max(longest[chunk], longestObstacle(static_cast<std::uint32_t>(v)));
        }
      }
    };
  });
  std::vector<std::uint32_t> border;
  longest_ = 0.0;
  for (std::size_t chunk = 0; chunk < found.size(); ++chunk) {
    longest_ = std::max(longest_, longest[chunk]);
    border.insert(border.end(), found[chunk].begin(), found[chunk].end());
  }
  return border;
}

/// The mesh in slabs across its longest axis, with about as many obstacles in each: with as much to
/// do.
std::vector<ObstacleDistance::Slab> ObstacleDistance::slabs(
    const std::vector<std::uint32_t>& obstacles, std::size_t threads) const
{
  WindowScope rest;
  rest.axis = parts_.axis();
  std::vector<double> sample;
  for (std::size_t i = 0; i < obstacles.size(); i += obstacles.size() / 4096 + 1) {
    const double at = rest.at(mesh_->position(obstacles[i]));
    if (std::isfinite(at)) {
      sample.push_back(at);
    }
  }
  std::sort(sample.begin(), sample.end());
  const std::size_t count =
      std::max(threads > 1 ? SLABS_PER_THREAD * threads : 1, obstacles.size() / MOST_OBSTACLES);
  const double width = PART_WIDTH * max_distance_;
  std::vector<Slab> slabs;
  for (std::size_t i = 1; i < count && !sample.empty(); ++i) {
    const double cut = sample[i * sample.size() / count];
    if (cut - std::max(rest.low, sample.front()) > width && sample.back() - cut > width) {
      slabs.push_back({rest, {}});
      slabs.back().scope.high = rest.low = cut;
    }
  }
  slabs.push_back({rest, {}});
  const auto isBefore = [](double at, const Slab& slab) { return at < slab.scope.high; };
  for (const std::uint32_t v : obstacles) {
    const double at = rest.at(mesh_->position(v));
    const auto slab = std::upper_bound(slabs.begin(), slabs.end() - 1, at, isBefore);
    slab->obstacles.push_back({v, at});
  }
  return slabs;
}

/// What is in one of the slabs.
bool ObstacleDistance::solveIn(const std::vector<Slab>& slabs, std::size_t slab,
                               WindowPropagation& propagation, const std::atomic<bool>* cancel)
{
  const WindowScope& scope = slabs[slab].scope;
  const double reach = max_distance_ + longest_;
  const double low = scope.low - reach, high = scope.high + reach;
  std::vector<std::uint32_t> border;
  for (const Slab& other : slabs) {
    if (other.scope.high < low || other.scope.low > high) {
      continue;
    }
    for (const Obstacle& obstacle : other.obstacles) {
      if (obstacle.at >= low && obstacle.at <= high) {
        border.push_back(obstacle.vertex);
      }
    }
  }
  if (!propagation.run(lethal_, border, scope, cancel)) {
    return false;
  }
  for (const std::uint32_t v : propagation.reached()) {
    if (scope.isIn(mesh_->position(v))) {
      take(v, propagation);
    }
  }
  return true;
}

/// Is a lethal vertex next to others?
bool ObstacleDistance::isAtBorder(std::uint32_t v) const
{
  const bool is_closed = mesh_->isClosed(v);  // then each b is an a, too
  for (const FastMarchingCorner& corner : mesh_->corners(v)) {
    if (lethal_[corner.a] == 0 || (!is_closed && lethal_[corner.b] == 0)) {
      return true;
    }
  }
  return false;
}

/// Length of the longest edge from a lethal vertex to another one.
double ObstacleDistance::longestObstacle(std::uint32_t v) const
{
  double squared = 0.0;
  for (const FastMarchingCorner& corner : mesh_->corners(v)) {
    for (const std::uint32_t u : {corner.a, corner.b}) {
      if (lethal_[u] != 0) {
        const Vector3 side = between(mesh_->position(v), mesh_->position(u));
        squared = std::max(squared, dot(side, side));
      }
    }
  }
  return std::sqrt(squared);
}

/// Has it changed?
bool ObstacleDistance::take(std::uint32_t v, const WindowPropagation& solved)
{
  const WindowLabel label = solved.label(v);
  const float distance = lethal_[v] != 0 ? 0.0f : distanceOf(label);
  const std::uint32_t start =
      distance > 0.0f && distance < INFINITE ? static_cast<std::uint32_t>(label) : 0;
  const bool is_changed = distance != distance_[v] || start != start_[v];
  distance_[v] = distance;
  start_[v] = start;
  return is_changed;
}

std::vector<std::uint32_t> ObstacleDistance::update(ArrayView<std::uint8_t> lethal,
                                                    double most_share)
{
  require(lethal.size() == lethal_.size(), "there have to be as many lethal flags as vertices");
  std::vector<std::uint32_t> changed;
  if (!known_) {
    compute(lethal);
    changed.resize(lethal_.size());
    std::iota(changed.begin(), changed.end(), 0u);
    return changed;
  }
  const std::vector<std::uint32_t> flipped = differences(lethal, lethal_);
  if (flipped.empty()) {
    return changed;
  }
  const auto most = static_cast<std::size_t>(most_share * static_cast<double>(lethal_.size()));
  known_ = false;  // should memory run out
  for (const std::uint32_t v : flipped) {
    lethal_[v] = lethal[v];
  }
  if (flipped.size() > most || !solveAround(flipped, most, changed)) {
    return computeAnew(lethal);
  }
  known_ = true;
  return changed;
}

/// As update(), from everything.
std::vector<std::uint32_t> ObstacleDistance::computeAnew(ArrayView<std::uint8_t> lethal)
{
  const LargeArray<float> distance = distance_;
  const LargeArray<std::uint32_t> start = start_;
  compute(lethal);
  std::vector<std::uint32_t> changed;
  for (std::uint32_t v = 0; v < distance_.size(); ++v) {
    if (distance_[v] != distance[v] || start_[v] != start[v]) {
      changed.push_back(v);
    }
  }
  return changed;
}

/// Solves what lies within the maximum distance of changes, which nothing else can be reached by.
/// False where that is more than `most` vertices; then nothing has been done.
bool ObstacleDistance::solveAround(const std::vector<std::uint32_t>& flipped, std::size_t most,
                                   std::vector<std::uint32_t>& changed)
{
  if (!(2.0 * max_distance_ < std::numeric_limits<float>::max())) {
    return false;
  }
  // Straight-line distances are rounded in another way than those along the surface.
  const double reach = max_distance_ * (1.0 + 1e-5);
  const NearChanges near(*mesh_, flipped, lethal_, 2.0 * reach);
  gaps_.resize(lethal_.size(), max_distance_ * 1.00001f);
  parts_.sort();
  for (const std::uint32_t v : flipped) {
    longest_ = std::max(longest_, longestObstacle(v));
  }
  std::vector<std::uint32_t> around, wanted, border;
  for (std::size_t part = 0; part < parts_.size() && wanted.size() <= most; ++part) {
    if (!near.isNear(parts_, part, longest_)) {
      continue;
    }
    parts_.forEachBlock(part, [&](const VertexBox& box, ArrayView<std::uint32_t> vertices) {
      if (!near.isNear(box, longest_)) {
        return;
      }
      for (const std::uint32_t v : vertices) {
        if (lethal_[v] != 0 && isAtBorder(v)) {
          border.push_back(v);
        }
        const double distance = near.distance(v);
        if (distance <= 2.0 * reach) {
          gaps_[v] = static_cast<float>(std::max(0.0, distance - reach));
          around.push_back(v);
          if (distance <= reach) {
            wanted.push_back(v);
          }
        }
      }
    });
  }
  const bool is_possible = wanted.size() <= most;
  if (is_possible) {
    if (!around_) {
      around_ = std::make_unique<WindowPropagation>(*mesh_, max_distance_);
    }
    WindowScope scope;
    scope.gaps = gaps_.data();
    around_->run(lethal_, border, scope, nullptr);
    for (const std::uint32_t v : wanted) {
      if (take(v, *around_)) {
        changed.push_back(v);
      }
    }
    std::sort(changed.begin(), changed.end());
  }
  for (const std::uint32_t v : around) {
    gaps_[v] = max_distance_ * 1.00001f;
  }
  return is_possible;
}

/// From a vertex with a way.
Vector3 ObstacleDistance::sourceDirection(std::uint32_t v) const
{
  const ArrayView<FastMarchingCorner> row = mesh_->corners(v);
  const PathStart start = PathStart::unpack(row.size(), start_[v]);
  const FastMarchingCorner& corner = row[start.corner];
  const Vector3 a = between(mesh_->position(v), mesh_->position(corner.a)),
                b = between(mesh_->position(v), mesh_->position(corner.b));
  return -(a + start.along * (b - a));
}

std::array<float, 3> ObstacleDistance::direction(std::uint32_t v) const
{
  const auto isBetween = [this](std::uint32_t u) {
    return distance_[u] > 0.0f && distance_[u] < INFINITE;
  };
  Vector3 sum{};
  if (isBetween(v)) {
    sum = sourceDirection(v);
  } else if (distance_[v] == 0.0f) {
    const auto add = [&](std::uint32_t u) {
      if (isBetween(u)) {
        const Vector3 one = sourceDirection(u);
        const double length = norm(one);
        sum = length > 0.0 ? sum + one / length : sum;
      }
    };
    const bool is_closed = mesh_->isClosed(v);  // then each b is an a, too
    for (const FastMarchingCorner& corner : mesh_->corners(v)) {
      add(corner.a);
      if (!is_closed) {
        add(corner.b);
      }
    }
  }
  const double length = norm(sum);
  if (!(length > 1e-6 * 1e-6)) {
    return {};
  }
  return {static_cast<float>(sum[0] / length), static_cast<float>(sum[1] / length),
          static_cast<float>(sum[2] / length)};
}

}  // namespace mesh_map
