#include <mesh_map/front.h>
#include <mesh_map/parallel.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "front_fan.h"

namespace mesh_map {
namespace {

/// How many triangles are unfolded to divide one corner.
constexpr unsigned MAX_UNFOLDED = 16;

double squaredDistance(const PackedPosition& p, const PackedPosition& q)
{
  const double x = double{p.x} - q.x, y = double{p.y} - q.y, z = double{p.z} - q.z;
  return x * x + y * y + z * z;
}

}  // namespace

void SurfaceFront::findStencils(const FrontMesh& mesh, std::uint32_t v,
                                std::vector<std::pair<std::uint32_t, Stencil>>& found)
{
  for (const FrontCorner* corner = mesh.cornersBegin(v); corner != mesh.cornersEnd(v); ++corner) {
    const PackedPosition &o = mesh.position(v), &p = mesh.position(corner->a),
                         &q = mesh.position(corner->b);
    const double a = squaredDistance(o, p), b = squaredDistance(o, q), c = squaredDistance(p, q);
    const double product = 0.5 * (a + b - c);
    if (corner->a == corner->b || product >= 0.0) {
      continue;
    }
    const double length = std::sqrt(a);
    const PlanePoint first{length, 0.0};
    const PlanePoint second{product / length, std::sqrt(std::max(0.0, b - product * product / a))};
    PlanePoint low = first, high = second;
    std::uint32_t low_vertex = corner->a, high_vertex = corner->b, behind = v;
    for (unsigned i = 0; i < MAX_UNFOLDED; ++i) {
      const std::uint32_t t = mesh.across(low_vertex, high_vertex, behind);
      PlanePoint at;
      if (t == NO_INDEX || t == v ||
          !placeBeyond(low, high, squaredDistance(mesh.position(low_vertex), mesh.position(t)),
                       squaredDistance(mesh.position(high_vertex), mesh.position(t)), at)) {
        break;
      }
      const bool is_acute_to_first = dot(at, first) > 0.0, is_acute_to_second = dot(at, second) > 0;
      if (is_acute_to_first && is_acute_to_second) {
        const auto add = [&](std::uint32_t u, PlanePoint from) {
          const auto base = static_cast<float>(std::hypot(at.x - from.x, at.y - from.y));
          const auto to_u = static_cast<float>(std::sqrt(dot(from, from)));
          const auto to_t = static_cast<float>(std::sqrt(dot(at, at)));
          found.push_back({u, {v, t, base, to_u, to_t}});
          found.push_back({t, {v, u, base, to_t, to_u}});
        };
        add(corner->a, first);
        add(corner->b, second);
        break;
      }
      if (!is_acute_to_first && !is_acute_to_second) {
        break;  // behind: what is unfolded has come round
      }
      // What divides the corner lies on the side of the one that this vertex is too far from.
      behind = is_acute_to_second ? high_vertex : low_vertex;
      (is_acute_to_second ? high : low) = at;
      (is_acute_to_second ? high_vertex : low_vertex) = t;
    }
  }
}

SurfaceFront::SurfaceFront(std::shared_ptr<const FrontMesh> mesh, unsigned threads)
    : mesh_(std::move(mesh)), stencil_offsets_(mesh_->vertexCount() + 1)
{
  using Found = std::vector<std::pair<std::uint32_t, Stencil>>;
  constexpr std::size_t CHUNK = 16384;
  const std::size_t count = mesh_->vertexCount();
  std::vector<Found> chunks((count + CHUNK - 1) / CHUNK);
  parallelFor(count, CHUNK, threads, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        findStencils(*mesh_, static_cast<std::uint32_t>(v), chunks[begin / CHUNK]);
      }
    };
  });
  std::size_t total = 0;
  for (const Found& chunk : chunks) {
    total += chunk.size();
    for (const auto& [vertex, stencil] : chunk) {
      ++stencil_offsets_[vertex + 1];
    }
  }
  if (total >= NO_INDEX) {
    throw std::invalid_argument("the mesh is too large for a front");
  }
  for (std::size_t v = 0; v < count; ++v) {
    stencil_offsets_[v + 1] += stencil_offsets_[v];
  }
  stencils_.resize(total);
  std::vector<std::uint32_t> next(stencil_offsets_.begin(), stencil_offsets_.end());
  for (const Found& chunk : chunks) {
    for (const auto& [vertex, stencil] : chunk) {
      stencils_[next[vertex]++] = stencil;
    }
  }
}

}  // namespace mesh_map
