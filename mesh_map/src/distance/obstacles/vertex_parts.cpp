#include "distance/obstacles/vertex_parts.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <limits>

namespace mesh_map {
namespace {

constexpr std::size_t MIN_PART = 16384;
constexpr std::size_t MAX_PARTS = 250;

}  // namespace

VertexParts::VertexParts(const FastMarchingMesh& mesh, double width, unsigned threads)
    : order_(mesh.vertexCount())
{
  const std::size_t count = mesh.vertexCount(), step = count / 16384 + 1;
  std::vector<float> sample;
  for (const unsigned axis : {2u, 1u, 0u}) {
    std::vector<float> values;
    for (std::size_t v = 0; v < count; v += step) {
      const PackedPosition& p = mesh.position(static_cast<std::uint32_t>(v));
      values.push_back(axis == 0 ? p.x : axis == 1 ? p.y : p.z);
    }
    std::sort(values.begin(), values.end());
    if (sample.empty() || values.back() - values.front() >= sample.back() - sample.front()) {
      sample = values;
      axis_ = axis;
    }
  }
  const double most = sample.empty() ? 0.0 : (double{sample.back()} - sample.front()) / width;
  std::size_t parts = std::min(count / MIN_PART, MAX_PARTS);
  parts = std::max<std::size_t>(
      1, most < static_cast<double>(parts) ? static_cast<std::size_t>(most) : parts);
  std::vector<float> cuts;
  for (std::size_t i = 1; i < parts; ++i) {
    cuts.push_back(sample[i * sample.size() / parts]);
  }
  std::vector<std::uint8_t> of(count);
  parallelEach(count, 16384, threads, [&](std::size_t v) {
    const float value = coordinate(mesh.position(static_cast<std::uint32_t>(v)));
    of[v] =
        static_cast<std::uint8_t>(std::upper_bound(cuts.begin(), cuts.end(), value) - cuts.begin());
  });
  parts_.resize(parts, Part{});
  for (const std::uint8_t part : of) {
    ++parts_[part].end;
  }
  std::size_t begin = 0;
  std::vector<std::size_t> next;
  for (Part& part : parts_) {
    part.begin = begin;
    next.push_back(begin);
    part.end = begin += part.end;
  }
  for (std::size_t v = 0; v < count; ++v) {
    order_[next[of[v]]++] = static_cast<std::uint32_t>(v);
  }
  parallelEach(parts, 1, threads, [&](std::size_t i) {
    constexpr float INFINITE = std::numeric_limits<float>::infinity();
    Part& part = parts_[i];
    part.low = part.edges_low = INFINITE;
    part.high = part.edges_high = -INFINITE;
    for (const std::uint32_t v : vertices(i)) {
      const float at = coordinate(mesh.position(v));
      part.low = std::min(part.low, at);
      part.high = std::max(part.high, at);
      for (const FastMarchingCorner& corner : mesh.corners(v)) {
        for (const std::uint32_t u : {corner.a, corner.b}) {
          const float other = coordinate(mesh.position(u));
          part.edges_low = std::min(part.edges_low, other);
          part.edges_high = std::max(part.edges_high, other);
        }
      }
    }
    part.edges_low = std::min(part.edges_low, part.low);
    part.edges_high = std::max(part.edges_high, part.high);
  });
}

}  // namespace mesh_map
