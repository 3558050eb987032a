#include "bvh/tree/bvh_frame.h"

#include <algorithm>
#include <cmath>

#include "bvh/tree/bvh_check.h"

namespace mesh_map {

namespace {

constexpr std::size_t SAMPLES = 4096;

/// A mesh that lies within so many times its extent from its origin needs no center of its own.
constexpr double NEAR = 8.0;

/// A box of all samples is good enough where it is at most so much larger than that of most.
constexpr float STRETCH = 8.0f;

struct Quantiles
{
  float lowest, low, middle, high, highest;
};

/// Quantiles 0, 1/32, 1/2, 31/32 and 1.
Quantiles quantiles(std::vector<float>& values)
{
  std::sort(values.begin(), values.end());
  const std::size_t last = values.size() - 1, few = values.size() / 32;
  return {values[0], values[few], values[values.size() / 2], values[last - few], values[last]};
}

}  // namespace

FaceSample::FaceSample(const MeshView& mesh) : mesh_(mesh)
{
  const std::size_t count = std::min(mesh.faceCount(), SAMPLES);
  faces_.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t face = i * mesh.faceCount() / count;
    if (facesAreSound(mesh, face, face + 1)) {
      faces_.push_back(static_cast<std::uint32_t>(face));
    }
  }
}

std::array<float, 3> FaceSample::center() const
{
  std::array<float, 3> result{};
  std::vector<float> values(3 * faces_.size());
  for (std::size_t axis = 0; axis < 3 && !faces_.empty(); ++axis) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = mesh_.positions[3 * std::size_t{mesh_.faces[3 * faces_[i / 3] + i % 3]} + axis];
    }
    const Quantiles found = quantiles(values);
    const double extent = double{found.high} - found.low, middle = found.middle;
    if (std::abs(middle) <= NEAR * extent || std::abs(middle) > 0.5 * LocalFrame::LARGEST_CENTER) {
      continue;
    }
    const double grid = extent > 0.0 ? std::exp2(std::ceil(std::log2(extent))) : 0.0;
    result[axis] = static_cast<float>(grid > 0.0 ? std::nearbyint(middle / grid) * grid : middle);
  }
  return result;
}

FloatBox FaceSample::mainBox(const LocalFrame& frame) const
{
  FloatBox result;
  std::vector<float> values(faces_.size());
  for (int axis = 0; axis < 3 && !faces_.empty(); ++axis) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const FloatBox box = frame.box(mesh_, faces_[i]);
      const float center = box.lower[axis] + box.upper[axis];
      values[i] = std::isnan(center) ? 0.0f : center;  // of -inf and +inf
    }
    const Quantiles found = quantiles(values);
    const float most = found.high - found.low, all = found.highest - found.lowest;
    const float margin = most / 16.0f;
    result.lower[axis] = all <= STRETCH * most ? found.lowest : found.low - margin;
    result.upper[axis] = all <= STRETCH * most ? found.highest : found.high + margin;
  }
  return result;
}

}  // namespace mesh_map
