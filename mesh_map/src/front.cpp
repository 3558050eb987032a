#include <mesh_map/front.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "front_queue.h"

namespace mesh_map {
namespace {

constexpr float INFINITE = std::numeric_limits<float>::infinity();

constexpr std::uint32_t STEPS_PER_CANCEL_CHECK = 4096;

void require(bool condition, const std::string& message)
{
  if (!condition) {
    throw std::invalid_argument(message);
  }
}

float length(const PackedPosition& p, const PackedPosition& q)
{
  const float x = p.x - q.x, y = p.y - q.y, z = p.z - q.z;
  return std::sqrt(x * x + y * y + z * z);
}

/// The distance of the third corner of a triangle from a point source, given those of the other two
/// (u and v, `base` apart) and its own distances from them (a and b). In a plane with the first at
/// the origin and the second on the x axis, the source lies at (sx, -sy), the corner at (p, h).
/// Infinite where there is no such source, or the way does not cross the base.
float circular(float u, float v, float base, float a, float b)
{
  const float half = 0.5f / base;
  const float sx = half * (base * base + (u - v) * (u + v));
  const float sy_squared = (u - sx) * (u + sx);
  const float p = half * (base * base + (a - b) * (a + b));
  const float h_squared = (a - p) * (a + p);
  if (!(sy_squared >= 0.0f && h_squared >= 0.0f)) {
    return INFINITE;
  }
  const float sy = std::sqrt(sy_squared), h = std::sqrt(h_squared);
  const float crossing = sx * h + p * sy;
  if (!(crossing >= 0.0f && crossing <= base * (sy + h))) {
    return INFINITE;
  }
  // sqrt(u * u + more), without losing what u and the result differ by.
  const float more = std::max(0.0f, a * a + 2.0f * (sy * h - sx * p));
  const float sum = u + std::sqrt(u * u + more);
  return sum > 0.0f ? u + more / sum : 0.0f;
}

}  // namespace

/// One front: the distances while they grow.
class SurfaceFront::Run
{
 public:
  Run(const SurfaceFront& front, const FrontQuery& query)
      : front_(front),
        mesh_(*front.mesh_),
        query_(query),
        distance_(mesh_.vertexCount(), INFINITE),
        queue_(0.25 * mesh_.meanEdge() * slownessScale(query.slowness))
  {
  }

  FrontField solve()
  {
    for (std::size_t i = 0; i < query_.sources.size(); ++i) {
      if (slowness(query_.sources[i]) < INFINITE) {
        offer(query_.sources[i], query_.source_distances[i]);
      }
    }
    bool is_cancelled = query_.cancel != nullptr && query_.cancel->load();
    FrontEntry entry;
    for (std::uint32_t steps = 1; !is_cancelled && queue_.pop(entry); ++steps) {
      prefetch();
      if (entry.distance == distance_[entry.vertex]) {
        spread(entry.vertex);
      }
      is_cancelled =
          steps % STEPS_PER_CANCEL_CHECK == 0 && query_.cancel != nullptr && query_.cancel->load();
    }
    return {std::move(distance_), is_cancelled};
  }

 private:
  /// The mean of what is finite and above 0, of a sample: for the width of buckets.
  static double slownessScale(ArrayView<float> slowness)
  {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t v = 0; v < slowness.size(); v += slowness.size() / 4096 + 1) {
      if (slowness[v] > 0.0f && slowness[v] < INFINITE) {
        sum += slowness[v];
        ++count;
      }
    }
    return count > 0 ? sum / static_cast<double>(count) : 1.0;
  }

  /// Infinite also for NaN.
  float slowness(std::uint32_t v) const
  {
    const float value = query_.slowness.empty() ? 1.0f : query_.slowness[v];
    return value < INFINITE ? value : INFINITE;
  }

  void offer(std::uint32_t v, float distance)
  {
    if (distance < distance_[v] && distance <= query_.max_distance) {
      distance_[v] = distance;
      queue_.push(distance, v);
    }
  }

  bool isDone(std::uint32_t v) const
  {
    const float distance = distance_[v];
    return distance < here_ || (distance == here_ && v < vertex_);
  }

  void spread(std::uint32_t vertex)
  {
    vertex_ = vertex;
    here_ = distance_[vertex];
    const float slow = slowness(vertex);
    const PackedPosition& at = mesh_.position(vertex);
    const FrontCorner* const end = mesh_.cornersEnd(vertex);
    for (const FrontCorner* corner = mesh_.cornersBegin(vertex); corner != end; ++corner) {
      const bool a_done = isDone(corner->a), b_done = isDone(corner->b);
      if (corner->a == vertex || (a_done && b_done)) {
        continue;
      }
      const PackedPosition &p = mesh_.position(corner->a), &q = mesh_.position(corner->b);
      const float to_a = length(at, p), to_b = length(at, q);
      const float slow_a = slowness(corner->a), slow_b = slowness(corner->b);
      if (!a_done && slow_a < INFINITE) {
        offer(corner->a, here_ + 0.5f * (slow + slow_a) * to_a);
      }
      if (!b_done && slow_b < INFINITE) {
        offer(corner->b, here_ + 0.5f * (slow + slow_b) * to_b);
      }
      if (a_done != b_done && corner->a != corner->b) {
        cross(a_done ? corner->b : corner->a, a_done ? corner->a : corner->b,
              slow + slow_a + slow_b, a_done ? to_a : to_b, a_done ? to_b : to_a, length(p, q));
      }
    }
    for (std::uint32_t i = front_.stencil_offsets_[vertex]; i < front_.stencil_offsets_[vertex + 1];
         ++i) {
      const Stencil& stencil = front_.stencils_[i];
      if (isDone(stencil.partner) && !isDone(stencil.target)) {
        cross(stencil.target, stencil.partner,
              slow + slowness(stencil.partner) + slowness(stencil.target), stencil.base,
              stencil.to_target, stencil.partner_to_target);
      }
    }
  }

  /// All sides of the triangle are scaled alike, so that it remains one.
  void cross(std::uint32_t target, std::uint32_t partner, float slowness_sum, float base,
             float to_target, float partner_to_target)
  {
    const float scale = query_.slowness.empty() ? 1.0f : slowness_sum / 3.0f;
    if (scale < INFINITE && base > 0.0f) {
      const float found = circular(here_, distance_[partner], scale * base, scale * to_target,
                                   scale * partner_to_target);
      offer(target, std::max(found, here_));
    }
  }

  void prefetch() const
  {
    if (const std::uint32_t v = queue_.peek(16); v != NO_INDEX) {
      mesh_.prefetchRow(v);
      mesh_.prefetchVertex(v);
      __builtin_prefetch(&distance_[v]);
      __builtin_prefetch(&front_.stencil_offsets_[v]);
    }
    if (const std::uint32_t v = queue_.peek(8); v != NO_INDEX) {
      mesh_.prefetchCorners(v);
      __builtin_prefetch(front_.stencils_.data() + front_.stencil_offsets_[v]);
    }
    if (const std::uint32_t v = queue_.peek(3); v != NO_INDEX) {
      for (const FrontCorner* corner = mesh_.cornersBegin(v); corner != mesh_.cornersEnd(v);
           ++corner) {
        mesh_.prefetchVertex(corner->a);
        __builtin_prefetch(&distance_[corner->a]);
      }
    }
  }

  const SurfaceFront& front_;
  const FrontMesh& mesh_;
  const FrontQuery& query_;
  std::vector<float> distance_;
  FrontQueue queue_;
  std::uint32_t vertex_ = 0;
  float here_ = 0.0f;
};

FrontField SurfaceFront::solve(const FrontQuery& query) const
{
  const std::size_t count = mesh_->vertexCount();
  require(query.sources.size() == query.source_distances.size(),
          "there have to be as many source distances as sources");
  require(query.slowness.empty() || query.slowness.size() == count,
          "there are " + std::to_string(query.slowness.size()) + " values of slowness for " +
              std::to_string(count) + " vertices");
  require(query.max_distance >= 0.0f, "the maximum distance has to be 0 or more");
  for (std::size_t i = 0; i < query.sources.size(); ++i) {
    require(query.sources[i] < count,
            "source vertex " + std::to_string(query.sources[i]) + " does not exist");
    require(query.source_distances[i] >= 0.0f && query.source_distances[i] < INFINITE,
            "the distance of source " + std::to_string(i) + " has to be finite and 0 or more");
  }
  for (std::size_t v = 0; v < query.slowness.size(); ++v) {
    require(!(query.slowness[v] < 0.0f),
            "the slowness of vertex " + std::to_string(v) + " is negative");
  }
  return Run(*this, query).solve();
}

}  // namespace mesh_map
