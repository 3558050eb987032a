#include <mesh_map/obstacle_distance.h>
#include <mesh_map/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "obstacle_spread.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

}  // namespace

ObstacleDistance::ObstacleDistance(std::shared_ptr<const FrontMesh> mesh, float max_distance)
    : mesh_(std::move(mesh)),
      max_distance_(max_distance),
      lethal_(mesh_->vertexCount()),
      distance_(mesh_->vertexCount()),
      source_(mesh_->vertexCount()),
      stamps_(mesh_->vertexCount())
{
  if (!(max_distance > 0.0f)) {
    throw std::invalid_argument("the maximum distance has to be above 0");
  }
}

bool ObstacleDistance::compute(ArrayView<std::uint8_t> lethal, const std::atomic<bool>* cancel,
                               unsigned threads)
{
  if (lethal.size() != lethal_.size()) {
    throw std::invalid_argument("there have to be as many lethal flags as vertices");
  }
  known_ = false;  // until it ends
  lethal_.assign(lethal.begin(), lethal.end());
  parallelFor(distance_.size(), 16384, threads, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        distance_[v] = lethal_[v] != 0 ? 0.0f : INFINITE;
        seed(static_cast<std::uint32_t>(v));
      }
    };
  });
  known_ = solveParts(cancel, threads);
  return known_;
}

/// What a vertex gets of the lethal ones next to it: points, and edges between two. Their faces
/// have such an edge toward whatever is not lethal, and the middle of a lethal area seeds nothing.
void ObstacleDistance::seed(std::uint32_t v)
{
  if (lethal_[v] != 0) {
    return;
  }
  for (const FrontCorner* corner = mesh_->cornersBegin(v); corner != mesh_->cornersEnd(v);
       ++corner) {
    if (lethal_[corner->a] == 0 && lethal_[corner->b] == 0) {
      continue;
    }
    const bool has_both = corner->a != corner->b && lethal_[corner->a] != 0 &&
                          lethal_[corner->b] != 0;
    // Of two lethal vertices, either may be the axis: the lower one, whatever the face.
    const bool a_first = has_both ? corner->a < corner->b : lethal_[corner->a] != 0;
    const std::uint32_t axis = a_first ? corner->a : corner->b;
    const std::uint32_t side = a_first ? corner->b : corner->a;
    const PackedPosition &o = mesh_->position(v), &p = mesh_->position(axis),
                         &q = mesh_->position(side);
    const double x = double{p.x} - o.x, y = double{p.y} - o.y, z = double{p.z} - o.z;
    const double length = std::sqrt(x * x + y * y + z * z);
    PlanePoint a{length, 0.0}, b = a;
    if (has_both) {
      const double i = double{q.x} - o.x, j = double{q.y} - o.y, k = double{q.z} - o.z;
      const double l = y * k - z * j, m = z * i - x * k, n = x * j - y * i;
      b = length > 0.0 ? PlanePoint{(x * i + y * j + z * k) / length,
                                    std::sqrt(l * l + m * m + n * n) / length}
                       : PlanePoint{std::sqrt(i * i + j * j + k * k), 0.0};
    }
    const PlanePoint nearest = nearestOnSegment(a, b, {0.0, 0.0});
    const float distance =
        std::max(above(0.0f), static_cast<float>(std::sqrt(dot(nearest, nearest))));
    const Source source{0.0f,
                        static_cast<float>(a.x),
                        static_cast<float>(a.y),
                        static_cast<float>(b.x),
                        static_cast<float>(b.y),
                        axis,
                        side};
    if (distance <= max_distance_ &&
        std::tie(distance, axis, side) <
            std::tie(distance_[v], source_[v].axis, source_[v].side)) {
      distance_[v] = distance;
      source_[v] = source;
    }
  }
}

std::array<double, 3> ObstacleDistance::sourceDirection(std::uint32_t v) const
{
  const Source& source = source_[v];
  const PlanePoint nearest =
      nearestOnSegment({source.ax, source.ay}, {source.bx, source.by}, {0.0, 0.0});
  const PackedPosition &o = mesh_->position(v), &p = mesh_->position(source.axis),
                       &q = mesh_->position(source.side);
  double x[3] = {double{p.x} - o.x, double{p.y} - o.y, double{p.z} - o.z};
  double y[3] = {double{q.x} - o.x, double{q.y} - o.y, double{q.z} - o.z};
  const double length = std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
  double along = 0.0, height = 0.0;
  for (unsigned i = 0; i < 3; ++i) {
    x[i] = length > 0.0 ? x[i] / length : 0.0;
    along += x[i] * y[i];
  }
  for (unsigned i = 0; i < 3; ++i) {
    y[i] -= along * x[i];
    height += y[i] * y[i];
  }
  height = std::sqrt(height);
  std::array<double, 3> direction{};
  for (unsigned i = 0; i < 3; ++i) {
    direction[i] = -(nearest.x * x[i] + (height > 0.0 ? nearest.y * y[i] / height : 0.0));
  }
  return direction;
}

std::array<float, 3> ObstacleDistance::direction(std::uint32_t v) const
{
  const auto isBetween = [this](std::uint32_t u) {
    return distance_[u] > 0.0f && distance_[u] < INFINITE;
  };
  const auto norm = [](const std::array<double, 3>& d) {
    return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  };
  std::array<double, 3> sum{};
  if (isBetween(v)) {
    sum = sourceDirection(v);
  } else if (distance_[v] == 0.0f) {
    for (const FrontCorner* corner = mesh_->cornersBegin(v); corner != mesh_->cornersEnd(v);
         ++corner) {
      for (const std::uint32_t u : {corner->a, corner->b}) {
        if (isBetween(u)) {
          const std::array<double, 3> one = sourceDirection(u);
          const double length = norm(one);
          for (unsigned i = 0; i < 3 && length > 0.0; ++i) {
            sum[i] += one[i] / length;
          }
        }
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
