#include "distance/obstacles/obstacle_distance.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "distance/obstacles/obstacle_spread.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

}  // namespace

ObstacleDistance::ObstacleDistance(std::shared_ptr<const FrontMesh> mesh, float max_distance)
    : mesh_(std::move(mesh)),
      max_distance_(max_distance),
      lethal_(mesh_->vertexCount()),
      distance_(mesh_->vertexCount(), INFINITE),
      source_(mesh_->vertexCount(), Source{}),
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
    return [&, fan = std::make_shared<FrontFan>()](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        distance_[v] = lethal_[v] != 0 ? 0.0f : INFINITE;
        seed(static_cast<std::uint32_t>(v), *fan);
      }
    };
  });
  known_ = solveParts(cancel, threads);
  return known_;
}

/// What a vertex gets of the lethal ones next to it: points, and edges from these to others that
/// are lethal, as far as the vertex lies beside such an edge. Whatever lethal area is farther away
/// has such edges in between, and the middle of one seeds nothing.
void ObstacleDistance::seed(std::uint32_t v, FrontFan& fan)
{
  if (lethal_[v] != 0) {
    return;
  }
  const FrontCorner* const end = mesh_->cornersEnd(v);
  for (const FrontCorner* corner = mesh_->cornersBegin(v); corner != end; ++corner) {
    if (lethal_[corner->a] != 0) {
      seedFrom(corner->a, v, corner->b, fan);
    }
    if (lethal_[corner->b] != 0) {
      seedFrom(corner->b, v, corner->a, fan);
    }
  }
}

/// From a lethal vertex, by the face that also has the vertex `side`: walks that way around it, to
/// the first edge to another lethal vertex, up to a right angle. Where the faces around it are not
/// one fan, which may be very many, that face alone counts.
void ObstacleDistance::seedFrom(std::uint32_t lethal, std::uint32_t v, std::uint32_t side,
                                FrontFan& fan)
{
  if (!mesh_->isFan(lethal)) {
    const FrontFan::Node from = FrontFan::node(mesh_->position(lethal), mesh_->position(v), v);
    const PlanePoint point{from.length, 0.0};
    offerSeed(v, lethal, side, point, point);
    if (side != v && side != lethal && lethal_[side] != 0) {
      const FrontFan::Node to =
          FrontFan::node(mesh_->position(lethal), mesh_->position(side), side);
      const FrontFan::Turn by = FrontFan::turn(from, to);
      offerSeed(v, lethal, side, point, {from.length - to.length * by.cosine, to.length * by.sine});
    }
    return;
  }
  fan.gather(*mesh_, lethal);
  const std::size_t start = fan.find(v);
  const double length = fan.nodes()[start].length;
  const PlanePoint a{length, 0.0};
  offerSeed(v, lethal, side, a, a);
  fan.walk(start, fan.find(side), true, [&](const FanStep& step) {
    if (step.direction.x < 0.0 || step.direction.y < 0.0) {
      return false;
    }
    const FrontFan::Node& node = fan.nodes()[step.node];
    if (lethal_[node.vertex] == 0) {
      return true;
    }
    offerSeed(v, lethal, side, a,
              {length - node.length * step.direction.x, node.length * step.direction.y});
    return false;
  });
}

void ObstacleDistance::offerSeed(std::uint32_t v, std::uint32_t axis, std::uint32_t side,
                                 PlanePoint a, PlanePoint b)
{
  const PlanePoint nearest = nearestOnSegment(a, b, {0.0, 0.0});
  const float distance =
      std::max(above(0.0f), static_cast<float>(std::sqrt(dot(nearest, nearest))));
  const Source& known = source_[v];
  const bool is_tie = distance == distance_[v];
  // At the same distance an edge is better than a point of it: it is as near to all others.
  const bool is_point = a.x == b.x && a.y == b.y;
  const bool known_point = known.ax == known.bx && known.ay == known.by;
  if (distance > max_distance_ || distance > distance_[v] ||
      (is_tie && std::tie(is_point, axis, side) >= std::tie(known_point, known.axis, known.side))) {
    return;
  }
  distance_[v] = distance;
  source_[v] = {0.0f,
                static_cast<float>(a.x),
                static_cast<float>(a.y),
                static_cast<float>(b.x),
                static_cast<float>(b.y),
                axis,
                side};
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
