#include "distance/obstacles/obstacle_distance.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/require.h"
#include "distance/obstacles/obstacle_propagation.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

}  // namespace

ObstacleDistance::ObstacleDistance(std::shared_ptr<const FastMarchingMesh> mesh, float max_distance)
    : mesh_(std::move(mesh)),
      max_distance_(max_distance),
      lethal_(mesh_->vertexCount()),
      distance_(mesh_->vertexCount(), INFINITE),
      source_(mesh_->vertexCount(), Source{}),
      stamps_(mesh_->vertexCount())
{
  require(max_distance > 0.0f, "the maximum distance has to be above 0");
}

bool ObstacleDistance::compute(ArrayView<std::uint8_t> lethal, const std::atomic<bool>* cancel,
                               unsigned threads)
{
  require(lethal.size() == lethal_.size(), "there have to be as many lethal flags as vertices");
  known_ = false;  // until it ends
  lethal_.assign(lethal.begin(), lethal.end());
  parallelFor(distance_.size(), 16384, threads, [&]() -> RangeBody {
    return [&, fan = std::make_shared<VertexFan>()](std::size_t begin, std::size_t end) {
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
void ObstacleDistance::seed(std::uint32_t v, VertexFan& fan)
{
  if (lethal_[v] != 0) {
    return;
  }
  for (const FastMarchingCorner& corner : mesh_->corners(v)) {
    if (lethal_[corner.a] != 0) {
      seedFrom(corner.a, v, corner.b, fan);
    }
    if (lethal_[corner.b] != 0) {
      seedFrom(corner.b, v, corner.a, fan);
    }
  }
}

/// From a lethal vertex, by the face that also has the vertex `side`: walks that way around it, to
/// the first edge to another lethal vertex, up to a right angle. Where the faces around it are not
/// one fan, which may be very many, that face alone counts.
void ObstacleDistance::seedFrom(std::uint32_t lethal, std::uint32_t v, std::uint32_t side,
                                VertexFan& fan)
{
  if (!mesh_->isFan(lethal)) {
    const VertexFan::Node from = VertexFan::node(mesh_->position(lethal), mesh_->position(v), v);
    const Vector2 point{from.length, 0.0};
    offerSeed(v, lethal, side, point, point);
    if (side != v && side != lethal && lethal_[side] != 0) {
      const VertexFan::Node to =
          VertexFan::node(mesh_->position(lethal), mesh_->position(side), side);
      const VertexFan::Turn by = VertexFan::turn(from, to);
      offerSeed(v, lethal, side, point, {from.length - to.length * by.cosine, to.length * by.sine});
    }
    return;
  }
  fan.gather(*mesh_, lethal);
  const std::size_t start = fan.find(v);
  const double length = fan.nodes()[start].length;
  const Vector2 a{length, 0.0};
  offerSeed(v, lethal, side, a, a);
  fan.walk(start, fan.find(side), true, [&](const FanStep& step) {
    if (step.direction[0] < 0.0 || step.direction[1] < 0.0) {
      return false;
    }
    const VertexFan::Node& node = fan.nodes()[step.node];
    if (lethal_[node.vertex] == 0) {
      return true;
    }
    offerSeed(v, lethal, side, a,
              {length - node.length * step.direction[0], node.length * step.direction[1]});
    return false;
  });
}

void ObstacleDistance::offerSeed(std::uint32_t v, std::uint32_t axis, std::uint32_t side, Vector2 a,
                                 Vector2 b)
{
  const Vector2 nearest = nearestOnSegment(a, b, {0.0, 0.0});
  const float distance = std::max(above(0.0f), static_cast<float>(norm(nearest)));
  const Source& known = source_[v];
  const bool is_tie = distance == distance_[v];
  // At the same distance an edge is better than a point of it: it is as near to all others.
  const bool is_point = a == b;
  const bool known_point = known.ax == known.bx && known.ay == known.by;
  if (distance > max_distance_ || distance > distance_[v] ||
      (is_tie && std::tie(is_point, axis, side) >= std::tie(known_point, known.axis, known.side))) {
    return;
  }
  distance_[v] = distance;
  source_[v] = sourceOf(0.0, a, b, axis, side);
}

ObstacleDistance::Source ObstacleDistance::sourceOf(double offset, const Vector2& a,
                                                    const Vector2& b, std::uint32_t axis,
                                                    std::uint32_t side)
{
  return {static_cast<float>(offset),
          static_cast<float>(a[0]),
          static_cast<float>(a[1]),
          static_cast<float>(b[0]),
          static_cast<float>(b[1]),
          axis,
          side};
}

Vector3 ObstacleDistance::sourceDirection(std::uint32_t v) const
{
  const Source& source = source_[v];
  const Vector2 nearest =
      nearestOnSegment({source.ax, source.ay}, {source.bx, source.by}, {0.0, 0.0});
  const Vector3 to_axis = between(mesh_->position(v), mesh_->position(source.axis)),
                to_side = between(mesh_->position(v), mesh_->position(source.side));
  const double length = norm(to_axis);
  const Vector3 x = length > 0.0 ? to_axis / length : Vector3{};
  const Vector3 y = to_side - dot(x, to_side) * x;
  const double height = norm(y);
  return -(nearest[0] * x + (height > 0.0 ? nearest[1] * y / height : Vector3{}));
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
    for (const FastMarchingCorner& corner : mesh_->corners(v)) {
      for (const std::uint32_t u : {corner.a, corner.b}) {
        if (isBetween(u)) {
          const Vector3 one = sourceDirection(u);
          const double length = norm(one);
          sum = length > 0.0 ? sum + one / length : sum;
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
