#include "distance/obstacles/vertex_parts.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace mesh_map {
namespace {

constexpr std::size_t MIN_PART = 16384;
constexpr std::size_t MAX_PARTS = 250;
constexpr std::size_t SAMPLES = 4096;

}  // namespace

VertexParts::VertexParts(const FastMarchingMesh& mesh, double width) : mesh_(mesh)
{
  const std::size_t count = mesh.vertexCount(), step = count / SAMPLES + 1;
  double longest = -1.0;
  for (const unsigned axis : {2u, 1u, 0u}) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t v = 0; v < count; v += step) {
      const PackedPosition& p = mesh.position(static_cast<std::uint32_t>(v));
      const double at = axis == 0 ? p.x : axis == 1 ? p.y : p.z;
      low = std::min(low, at);
      high = std::max(high, at);
    }
    if (high - low >= longest) {
      longest = high - low;
      axis_ = axis;
    }
  }
  std::size_t parts = std::min(count / MIN_PART, MAX_PARTS);
  const double most = longest / width;
  parts = most < static_cast<double>(parts) ? static_cast<std::size_t>(std::max(0.0, most)) : parts;
  if (parts < 2) {
    return;
  }
  std::vector<float> sample;
  for (std::size_t v = 0; v < count; v += step) {
    sample.push_back(coordinate(static_cast<std::uint32_t>(v)));
  }
  std::sort(sample.begin(), sample.end());
  for (std::size_t i = 1; i < parts; ++i) {
    cuts_.push_back(sample[i * sample.size() / parts]);
  }
}

void VertexParts::sort()
{
  if (is_sorted_) {
    return;
  }
  const std::size_t count = mesh_.vertexCount();
  std::vector<std::uint8_t> of(count);
  // Vertices beside each other in memory are mostly in one part.
  parallelEach(count, 16384, 0, [this, &of, last = std::size_t{0}](std::size_t i) mutable {
    const auto v = static_cast<std::uint32_t>(i);
    last = isIn(v, last) ? last : partOf(v);
    of[i] = static_cast<std::uint8_t>(last);
  });
  std::vector<std::size_t> next(size() + 1);
  for (const std::uint8_t part : of) {
    ++next[part + 1];
  }
  for (std::size_t part = 0; part < size(); ++part) {
    next[part + 1] += next[part];
  }
  order_.resize(count);
  begins_ = next;
  for (std::size_t v = 0; v < count; ++v) {
    order_[next[of[v]]++] = static_cast<std::uint32_t>(v);
  }
  findBoxes();
  is_sorted_ = true;  // all of it, also where memory has run out once
}

void VertexParts::findBoxes()
{
  constexpr float FAR = std::numeric_limits<float>::infinity();
  first_boxes_ = {0};
  for (std::size_t part = 0; part < size(); ++part) {
    first_boxes_.push_back(first_boxes_.back() +
                           (begins_[part + 1] - begins_[part] + BLOCK - 1) / BLOCK);
  }
  boxes_.assign(first_boxes_.back(), {{FAR, FAR, FAR}, {-FAR, -FAR, -FAR}});
  parallelEach(size(), 1, 0, [this](std::size_t part) {
    VertexBox* box = boxes_.data() + first_boxes_[part];
    forEachBlock(part, [&](const VertexBox&, ArrayView<std::uint32_t> vertices) {
      for (const std::uint32_t v : vertices) {
        const PackedPosition& p = mesh_.position(v);
        const bool is_somewhere = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
        box->add(is_somewhere ? VertexBox{{p.x, p.y, p.z}, {p.x, p.y, p.z}}
                              : VertexBox{{-FAR, -FAR, -FAR}, {FAR, FAR, FAR}});
      }
      ++box;
    });
  });
}

}  // namespace mesh_map
