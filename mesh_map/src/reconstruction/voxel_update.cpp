#include "reconstruction/voxel_update.h"

#include <algorithm>
#include <cmath>

#include "base/simd.h"

namespace mesh_map {
namespace {

constexpr float MOST_UNITS = MOST_WEIGHT * WEIGHT_UNITS;
constexpr float CARVE_WEIGHT = 0.3f;
constexpr float CARVE_WIDTH = 0.35f;  // voxels from a ray that are emptied
constexpr std::uint32_t MOST_OF_COLOR = 63, MOST_OBSERVATIONS = 65535;  // points of a mean
constexpr std::size_t LANES = 4;

/// From 0 to 1 (not 1): the same for the same two numbers.
float noiseOf(std::uint32_t a, std::uint32_t b)
{
  std::uint32_t bits = a * 0x9E3779B1u ^ b * 0x85EBCA77u;
  bits ^= bits >> 15;
  bits *= 0xC2B2AE3Du;
  bits ^= bits >> 13;
  return static_cast<float>(bits >> 8) * (1.0f / 16777216.0f);
}

/// A mean of few bits: what is lost by rounding is made up for on average.
std::uint8_t newMean(std::uint8_t mean, float value, float share, float noise)
{
  const float exact = static_cast<float>(mean) + share * (value - static_cast<float>(mean));
  return static_cast<std::uint8_t>(std::min(255.0f, exact + noise));
}

Floats4 toFloats(Ints4 a)
{
  return __builtin_convertvector(a, Floats4);
}

/// The nearest whole numbers.
Ints4 rounded(Floats4 a)
{
  const Ints4 sign = reinterpret_cast<Ints4>(a) & INT32_MIN;
  const Floats4 half = reinterpret_cast<Floats4>(sign | reinterpret_cast<Ints4>(all4(0.5f)));
  return __builtin_convertvector(a + half, Ints4);
}

}  // namespace

VoxelUpdate::VoxelUpdate(const FieldOptions& options, const MeasuredPoints& measured,
                         const MeasuredRays& rays, const PassageLists& lists)
    : measured_(measured),
      rays_(rays),
      lists_(lists),
      truncation_(static_cast<float>(options.truncation / options.voxel_size))
{
}

void VoxelUpdate::update(VoxelBlock& block, const GridPlace& place, const BlockPassages& passages)
{
  const auto middle = [](std::int32_t at) { return static_cast<float>(at * BLOCK_SIDE) + 0.5f; };
  const Vector3f low = {middle(place.x), middle(place.y), middle(place.z)};  // of the first voxel
  for (const BlockPassage* one = passages.first; one != nullptr; one = one->next) {
    if (one->count > 0) {
      measure(*one, low);
    } else {
      carve(*one, low, block);
    }
  }
  store(block);
}

/// The voxels of a passage are measured by its ray.
void VoxelUpdate::measure(const BlockPassage& passage, const Vector3f& low)
{
  const MeasuredRay& ray = rays_[passage.ray];
  const std::uint16_t* const voxels = lists_.voxels(passage);
  const Vector3f from = along(low, -1, ray.point);
  const float to_units = DISTANCE_UNITS / truncation_, weight = ray.weight * WEIGHT_UNITS;
  const float falloff = 1 / std::max(truncation_ - 1, 1e-3f);
  std::uint32_t near = 0;  // bits of voxels
  for (std::size_t i = 0; i < passage.count; i += LANES) {
    const Ints4 voxel = {voxels[i], voxels[i + 1], voxels[i + 2], voxels[i + 3]};
    const Floats4 x = all4(from[0]) + toFloats(voxel & 7);
    const Floats4 y = all4(from[1]) + toFloats((voxel >> 3) & 7);
    const Floats4 z = all4(from[2]) + toFloats(voxel >> 6);
    const Floats4 distance =
        all4(ray.normal[0]) * x + all4(ray.normal[1]) * y + all4(ray.normal[2]) * z;
    const Floats4 beside = x * x + y * y + z * z - distance * distance;
    // The same on both sides: of distances that err, those that count less or not at all would else
    // draw the surface away from them.
    const Floats4 away = absolute(distance);
    const Floats4 inside = (all4(truncation_) - away) * all4(falloff);
    const Floats4 share = maximum(all4(0), minimum(all4(1), inside));
    // Voxels behind those of the passage have none.
    const Ints4 left = Ints4{0, -1, -2, -3} + static_cast<std::int32_t>(passage.count - i);
    const Floats4 units = left > 0 ? all4(weight) * share / (all4(1) + beside) : all4(0);
    const Floats4 moment = units * distance * all4(to_units);
    near |= bits((units > all4(0)) & (away <= all4(1)) & (beside <= all4(1))) << i;
    for (std::size_t k = 0; k < LANES; ++k) {
      weights_[voxels[i + k]] += units[k];
      distances_[voxels[i + k]] += moment[k];
    }
  }
  for (; near != 0; near &= near - 1) {
    see(voxels[lowestBit(near)], rays_.point(passage.ray));
  }
}

/// What a ray passes on its way to where it is measured is empty, as far as it had been measured.
void VoxelUpdate::carve(const BlockPassage& passage, const Vector3f& low, const VoxelBlock& block)
{
  const Vector3f sensor = rays_.sensor(passage.ray), front = rays_.parts(passage.ray).front;
  const Vector3f way = along(front, -1, sensor);
  const float length = std::sqrt(dot(way, way));
  float enter = 0, leave = 1;  // where the ray is in the block
  for (std::size_t k = 0; k < 3; ++k) {
    const float start = low[k] - 0.5f - sensor[k], end = start + BLOCK_SIDE;
    if (way[k] != 0) {
      enter = std::max(enter, std::min(start / way[k], end / way[k]));
      leave = std::min(leave, std::max(start / way[k], end / way[k]));
    }
  }
  if (length <= truncation_ || enter > leave) {
    return;
  }
  const float units = CARVE_WEIGHT * WEIGHT_UNITS * rays_[passage.ray].weight;
  const Vector3f from = along(low, -1, front);
  const CellWalk within(along(sensor, enter, way), along(sensor, leave, way));
  within.each([&](std::uint64_t key) {
    const std::size_t voxel = voxelInBlock(key);
    const Vector3f at = {from[0] + static_cast<float>(voxel % BLOCK_SIDE),
                         from[1] + static_cast<float>(voxel / BLOCK_SIDE % BLOCK_SIDE),
                         from[2] + static_cast<float>(voxel / (BLOCK_SIDE * BLOCK_SIDE))};
    const float ahead = dot(at, way) / length;
    // By rounding, the first or the last one may lie in the next block: then it is far from the
    // ray in this one.
    if (dot(at, at) - ahead * ahead < CARVE_WIDTH * CARVE_WIDTH &&
        (block.distances[voxel].weight() > 0 || weights_[voxel] > 0)) {
      weights_[voxel] += units;
      distances_[voxel] += units * DISTANCE_UNITS;
    }
  });
}

/// A point lies near a voxel.
void VoxelUpdate::see(std::size_t voxel, std::size_t point)
{
  Seen& seen = seen_[voxel];
  ++seen.count;
  if (!measured_.colors.empty()) {
    const std::uint8_t* const color = measured_.colors.data() + 3 * point;
    seen.red += color[0];
    seen.green += color[1];
    seen.blue += color[2];
  }
  if (!measured_.intensities.empty() && std::isfinite(measured_.intensities[point])) {
    seen.intensities += measured_.intensities[point];
    seen.intensity_count += 1;
  }
}

/// All sums go into the block, and are 0 again.
void VoxelUpdate::store(VoxelBlock& block)
{
  for (std::size_t first = 0; first < BLOCK_VOXELS; first += LANES) {
    const Floats4 units = load4(weights_.data() + first);
    const unsigned measured = bits(units > all4(0));
    if (measured == 0) {
      continue;
    }
    Ints4 voxels;
    std::memcpy(&voxels, block.distances.data() + first, sizeof(voxels));
    const Floats4 mean = toFloats((voxels << 16) >> 16), sum = toFloats((voxels >> 16) & 0xFFFF);
    const Floats4 all = sum + units;
    const Ints4 new_mean = rounded(mean + (load4(distances_.data() + first) - mean * units) / all);
    const Ints4 new_sum = rounded(maximum(all4(1), minimum(all4(MOST_UNITS), all)));
    voxels = units > all4(0) ? (new_sum << 16) | (new_mean & 0xFFFF) : voxels;
    std::memcpy(&block.distances[first].bits, &voxels, sizeof(voxels));
    std::fill_n(weights_.begin() + first, LANES, 0.0f);
    std::fill_n(distances_.begin() + first, LANES, 0.0f);
    for (unsigned left = measured; left != 0; left &= left - 1) {
      const std::size_t voxel = first + lowestBit(left);
      if (seen_[voxel].count > 0) {
        storeSeen(block, voxel, seen_[voxel]);
        seen_[voxel] = Seen();
      }
    }
  }
}

void VoxelUpdate::storeSeen(VoxelBlock& block, std::size_t voxel, const Seen& seen) const
{
  std::uint16_t& observations = block.observations[voxel];
  const auto count = static_cast<float>(seen.count);
  if (block.intensities && seen.intensity_count > 0) {
    float& mean = (*block.intensities)[voxel];
    const auto before = static_cast<float>(std::min<std::uint32_t>(observations, MOST_OF_COLOR));
    mean += (seen.intensities - seen.intensity_count * mean) / (before + seen.intensity_count);
  }
  if (block.colors && !measured_.colors.empty()) {
    VoxelColor& color = (*block.colors)[voxel];
    const float share = count / (static_cast<float>(color.count) + count);
    const float noise = noiseOf(observations + seen.red, static_cast<std::uint32_t>(voxel));
    color.red = newMean(color.red, static_cast<float>(seen.red) / count, share, noise);
    color.green = newMean(color.green, static_cast<float>(seen.green) / count, share, noise);
    color.blue = newMean(color.blue, static_cast<float>(seen.blue) / count, share, noise);
    color.count = static_cast<std::uint8_t>(std::min(color.count + seen.count, MOST_OF_COLOR));
  }
  observations = static_cast<std::uint16_t>(
      std::min<std::uint32_t>(observations + seen.count, MOST_OBSERVATIONS));
}

}  // namespace mesh_map
