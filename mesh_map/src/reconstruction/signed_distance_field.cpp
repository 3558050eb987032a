#include "reconstruction/signed_distance_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/require.h"

namespace mesh_map {
namespace {

using Vector3f = std::array<float, 3>;

constexpr float TYPICAL_RANGE = 10.0f;  // m from which on a point counts clearly less
constexpr float LEAST_COSINE = 0.1f;    // of the incidence: its weight is never below
constexpr float STEEP_COSINE = 0.8f;    // of the incidence, above which ray and normal are one way
constexpr float MOST_UNITS = MOST_WEIGHT * WEIGHT_UNITS;
constexpr float CARVE_WEIGHT = 0.3f;
constexpr float CARVE_WIDTH = 0.35f;    // voxels from a ray that are emptied
constexpr unsigned MOST_OF_COLOR = 64;  // points that a color is the mean of
constexpr float CELL_VOXELS = 2.0f;     // side of the cells of normals
constexpr double NEAREST_POINT = 0.01;  // voxels from the sensor; nearer ones have no direction
constexpr unsigned RAY_BITS = 16;
constexpr std::size_t BATCH = 1 << RAY_BITS;  // rays whose blocks are listed at a time
// Parts of a ray.
constexpr std::uint32_t ALONG = 1 << RAY_BITS, ACROSS = 2 << RAY_BITS, CARVED = 4 << RAY_BITS;
constexpr std::size_t USUAL_BLOCKS = 4;
constexpr std::size_t RAYS = 1024;  // rays that a thread takes at a time

float dot(const Vector3f& a, const Vector3f& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// a + t b
Vector3f along(const Vector3f& a, float t, const Vector3f& b)
{
  return {a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]};
}

/// Calls visit(cell) for the cells of a grid of size 1 that a straight line from a to b passes
/// within the box from low to below high (J. Amanatides and A. Woo: A Fast Voxel Traversal
/// Algorithm for Ray Tracing, 1987).
template <class Visit>
void visitCells(const Vector3f& a, const Vector3f& b, const std::array<std::int32_t, 3>& low,
                const std::array<std::int32_t, 3>& high, const Visit& visit)
{
  float enter = 0, leave = 1;
  Vector3f way, inverse;
  for (std::size_t k = 0; k < 3; ++k) {
    way[k] = b[k] - a[k];
    if (!std::isfinite(way[k])) {
      return;
    }
    const auto from = static_cast<float>(low[k]), to = static_cast<float>(high[k]);
    if (std::abs(way[k]) < 1e-9f) {
      if (a[k] < from || a[k] >= to) {
        return;
      }
      inverse[k] = std::numeric_limits<float>::infinity();
      continue;
    }
    inverse[k] = 1 / way[k];
    const float first = (from - a[k]) * inverse[k], second = (to - a[k]) * inverse[k];
    enter = std::max(enter, std::min(first, second));
    leave = std::min(leave, std::max(first, second));
  }
  if (!(enter <= leave)) {
    return;
  }
  std::array<std::int32_t, 3> cell, step;
  Vector3f next, width;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto at = static_cast<std::int32_t>(std::floor(a[k] + enter * way[k]));
    cell[k] = std::clamp(at, low[k], high[k] - 1);
    step[k] = way[k] < 0 ? -1 : 1;
    width[k] = std::abs(inverse[k]);
    const auto border = static_cast<float>(cell[k] + (step[k] > 0 ? 1 : 0));
    next[k] = std::isinf(width[k]) ? width[k] : (border - a[k]) * inverse[k];
  }
  for (;;) {
    visit(cell);
    const std::size_t k =
        next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    if (next[k] > leave) {
      return;
    }
    cell[k] += step[k];
    next[k] += width[k];
    if (cell[k] < low[k] || cell[k] >= high[k]) {
      return;
    }
  }
}

/// The nearest whole number of one that fits.
template <class Whole>
Whole rounded(float value)
{
  return static_cast<Whole>(static_cast<std::int32_t>(value < 0 ? value - 0.5f : value + 0.5f));
}

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
std::uint8_t newMean(std::uint8_t mean, std::uint8_t value, float share, float noise)
{
  const float exact = static_cast<float>(mean) + share * (static_cast<float>(value) - mean);
  return static_cast<std::uint8_t>(std::min(255.0f, exact + noise));
}

}  // namespace

/// In voxels, but for its weight.
struct SignedDistanceField::Ray
{
  Vector3f point, normal;    ///< the normal towards the sensor
  Vector3f front, back;      ///< ends of the part along the ray
  Vector3f outside, inside;  ///< ends of the part across the surface; the same: there is none
  Vector3f sensor;           ///< where carving begins
  float weight = 0;
  std::uint32_t number = 0;  ///< of the point
};

struct SignedDistanceField::BlockRay
{
  std::uint64_t block;
  std::uint32_t ray;  ///< in the batch, and above it which of its parts meet the block
};

SignedDistanceField::SignedDistanceField(const FieldOptions& options)
    : options_(options), normals_(CELL_VOXELS * options.voxel_size)
{
  require(options.voxel_size > 0 && std::isfinite(options.voxel_size),
          "the voxel size has to be above 0 and finite");
  require(options.truncation >= options.voxel_size && std::isfinite(options.truncation),
          "the truncation has to be at least the voxel size, and finite");
}

std::size_t SignedDistanceField::blockMemory() const
{
  return sizeof(VoxelBlock) + (options_.colors ? BLOCK_VOXELS * sizeof(VoxelColor) : 0) +
         (options_.intensities ? BLOCK_VOXELS * sizeof(float) : 0);
}

std::size_t SignedDistanceField::memory() const
{
  return blocks_.index.memory() + normals_.memory() +
         blocks_.index.size() * (blockMemory() + sizeof(blocks_.blocks[0]));
}

void SignedDistanceField::checkMemory()
{
  const std::size_t needed = memory();
  if (needed > options_.memory_limit) {
    blocks_.blocks.resize(blocks_.index.size());
    throw FieldMemoryError(needed);
  }
}

std::unique_ptr<VoxelBlock> SignedDistanceField::newBlock() const
{
  auto block = std::make_unique<VoxelBlock>();
  if (options_.colors) {
    block->colors = std::make_unique<std::array<VoxelColor, BLOCK_VOXELS>>();
  }
  if (options_.intensities) {
    block->intensities = std::make_unique<std::array<float, BLOCK_VOXELS>>();
  }
  return block;
}

FieldState<StateVector> SignedDistanceField::state() const
{
  FieldState<StateVector> state;
  state.cell_keys = normals_.keys();
  state.cell_numbers = normals_.numbers();
  for (std::size_t i = 0; i < blocks_.blocks.size(); ++i) {
    const VoxelBlock* const block = blocks_.blocks[i].get();
    if (block == nullptr) {  // of points that did not find room
      continue;
    }
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    state.keys.push_back(blocks_.index.keys()[i]);
    append(state.distances, block->distances);
    append(state.weights, block->weights);
    append(state.observations, block->observations);
    if (block->intensities) {
      append(state.intensities, *block->intensities);
    }
    for (std::size_t v = 0; v < (block->colors ? BLOCK_VOXELS : 0); ++v) {
      const VoxelColor& color = (*block->colors)[v];
      append(state.colors, std::array{color.red, color.green, color.blue, color.count});
    }
  }
  return state;
}

void SignedDistanceField::restore(const FieldState<ArrayView>& state)
{
  const std::size_t count = state.keys.size(), voxels = count * BLOCK_VOXELS;
  require(state.distances.size() == voxels && state.weights.size() == voxels &&
              state.observations.size() == voxels &&
              state.colors.size() == (options_.colors ? 4 * voxels : 0) &&
              state.intensities.size() == (options_.intensities ? voxels : 0),
          "the state of a field has other arrays than its options ask for");
  require(std::all_of(state.cell_numbers.begin(), state.cell_numbers.end(),
                      [](float number) { return std::isfinite(number); }),
          "the state of a field has numbers that are not finite");
  VoxelBlocks blocks;
  for (std::size_t i = 0; i < count; ++i) {
    require(state.keys[i] >> 63 == 0 && blocks.index.add(state.keys[i]) == i,
            "the state of a field has a block twice, or one that is nowhere");
    auto block = newBlock();
    const std::size_t first = i * BLOCK_VOXELS;
    std::copy_n(state.distances.data() + first, BLOCK_VOXELS, block->distances.begin());
    std::copy_n(state.weights.data() + first, BLOCK_VOXELS, block->weights.begin());
    std::copy_n(state.observations.data() + first, BLOCK_VOXELS, block->observations.begin());
    if (block->intensities) {
      std::copy_n(state.intensities.data() + first, BLOCK_VOXELS, block->intensities->begin());
    }
    for (std::size_t v = 0; v < (block->colors ? BLOCK_VOXELS : 0); ++v) {
      const std::uint8_t* const color = state.colors.data() + 4 * (first + v);
      (*block->colors)[v] = {color[0], color[1], color[2], color[3]};
    }
    block->is_changed = true;
    blocks.blocks.push_back(std::move(block));
  }
  SurfaceNormals normals(CELL_VOXELS * options_.voxel_size);
  normals.restore(state.cell_keys, state.cell_numbers);
  normals_ = std::move(normals);
  blocks_ = std::move(blocks);
}

IntegrationCounts SignedDistanceField::integrate(const MeasuredPoints& measured,
                                                 const BvhOptions& options)
{
  Run run(options);
  const std::size_t count = measured.points.size() / 3;
  const bool one_origin = measured.origins.size() == 3;
  const auto voxels = static_cast<float>(1 / options_.voxel_size);
  const float limit = static_cast<float>(GridPlace::LIMIT - 2);
  const double least = std::max(options_.min_range, NEAREST_POINT * options_.voxel_size);
  const auto least_square = static_cast<float>(least * least);
  IntegrationCounts counts;
  std::vector<float> points;
  std::vector<Ray> rays;
  for (std::size_t begin = 0; begin < count; begin += BATCH) {
    const std::size_t end = std::min(count, begin + BATCH);
    points.clear();
    rays.clear();
    rays.reserve(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      const float* const point = measured.points.data() + 3 * i;
      const float* const origin = measured.origins.data() + (one_origin ? 0 : 3 * i);
      Ray& ray = rays.emplace_back();
      float square = 0;
      bool outside = false;
      for (std::size_t k = 0; k < 3; ++k) {
        ray.point[k] = point[k] * voxels;
        ray.sensor[k] = origin[k] * voxels;
        square += (point[k] - origin[k]) * (point[k] - origin[k]);
        outside =
            outside || !(std::abs(ray.point[k]) < limit) || !(std::abs(ray.sensor[k]) < limit);
      }
      std::size_t* const left_out = !std::isfinite(square)  ? &counts.not_finite
                                    : square < least_square ? &counts.too_near
                                    : square > options_.max_range * options_.max_range
                                        ? &counts.too_far
                                    : outside ? &counts.outside
                                              : nullptr;
      if (left_out != nullptr) {
        ++*left_out;
        rays.pop_back();
        continue;
      }
      const float range = std::sqrt(square) / TYPICAL_RANGE;
      ray.weight = 1 / (1 + range * range);
      ray.number = static_cast<std::uint32_t>(i);
      points.insert(points.end(), point, point + 3);
    }
    counts.used += rays.size();
    const std::vector<PointNormal> normals = normals_.add(points, run);
    checkMemory();
    addRays(rays, normals, measured, run);
  }
  return counts;
}

/// Its parts, by the normal of the surface where it ends.
void SignedDistanceField::aim(Ray& ray, const PointNormal& normal) const
{
  const auto truncation = static_cast<float>(options_.truncation / options_.voxel_size);
  Vector3f way = along(ray.point, -1, ray.sensor);
  const float length = std::sqrt(dot(way, way));
  way = {way[0] / length, way[1] / length, way[2] / length};
  const Vector3f plane = {normal.x, normal.y, normal.z};
  const float towards = dot(plane, way) > 0 ? -normal.flatness : normal.flatness;
  Vector3f mixed;
  for (std::size_t k = 0; k < 3; ++k) {
    mixed[k] = towards * plane[k] - (1 - normal.flatness) * way[k];
  }
  const float scale = 1 / std::sqrt(dot(mixed, mixed));
  ray.normal = {scale * mixed[0], scale * mixed[1], scale * mixed[2]};
  const float cosine = std::max(-dot(ray.normal, way), LEAST_COSINE);
  // A beam that grazes a surface lights a long spot on it, and tells less of its distance; on the
  // other hand the error of its range moves the point along the surface.
  ray.weight *= std::sqrt(cosine);
  // Where a ray grazes the ground, what it tells of that reaches farther: less of the ground
  // between the rings of a lidar stays open.
  const float reach = std::min(truncation / cosine, 2 * truncation);
  ray.front = along(ray.point, -std::min(reach, length), way);
  ray.back = along(ray.point, reach, way);
  ray.outside = ray.inside = ray.point;
  if (cosine < STEEP_COSINE) {
    ray.outside = along(ray.point, truncation, ray.normal);
    ray.inside = along(ray.point, -truncation, ray.normal);
  }
}

void SignedDistanceField::listBlocks(const Ray& ray, std::uint32_t number,
                                     std::vector<BlockRay>& listed) const
{
  constexpr float BLOCKS = 1.0f / BLOCK_SIDE;
  constexpr std::int32_t MOST = GridPlace::LIMIT;
  const std::size_t first = listed.size();
  const auto scaled = [](const Vector3f& at) {
    return Vector3f{at[0] * BLOCKS, at[1] * BLOCKS, at[2] * BLOCKS};
  };
  const auto add = [&](const std::array<std::int32_t, 3>& cell, std::uint32_t part) {
    const std::uint64_t key = GridPlace{cell[0], cell[1], cell[2]}.key();
    for (std::size_t i = first; i < listed.size(); ++i) {
      if (listed[i].block == key) {
        listed[i].ray |= part;
        return;
      }
    }
    listed.push_back({key, number | part});
  };
  const std::array<std::int32_t, 3> low = {-MOST, -MOST, -MOST}, high = {MOST, MOST, MOST};
  visitCells(scaled(ray.front), scaled(ray.back), low, high,
             [&](const std::array<std::int32_t, 3>& cell) { add(cell, ALONG); });
  if (ray.outside != ray.inside) {
    visitCells(scaled(ray.outside), scaled(ray.inside), low, high,
               [&](const std::array<std::int32_t, 3>& cell) { add(cell, ACROSS); });
  }
  if (options_.carve) {
    visitCells(scaled(ray.sensor), scaled(ray.front), low, high,
               [&](const std::array<std::int32_t, 3>& cell) {
                 const GridPlace place{cell[0], cell[1], cell[2]};
                 if (blocks_.index.find(place.key()) != KeyIndex::NONE) {
                   add(cell, CARVED);
                 }
               });
  }
}

void SignedDistanceField::addRays(std::vector<Ray>& rays, const std::vector<PointNormal>& normals,
                                  const MeasuredPoints& measured, Run& run)
{
  const std::size_t chunks = (rays.size() + RAYS - 1) / RAYS;
  std::vector<std::vector<BlockRay>> listed(chunks);
  run.each(chunks, 1, 0.0, [&](std::size_t chunk) {
    const std::size_t end = std::min(rays.size(), (chunk + 1) * RAYS);
    std::vector<BlockRay> own;  // of this thread alone, until it is done
    own.reserve(USUAL_BLOCKS * RAYS);
    for (std::size_t i = chunk * RAYS; i < end; ++i) {
      aim(rays[i], normals[i]);
      listBlocks(rays[i], static_cast<std::uint32_t>(i), own);
    }
    listed[chunk] = std::move(own);
  });

  // Blocks are numbered as the rays come: the result does not depend on who listed what.
  std::size_t count = 0;
  std::uint64_t last_key = ~std::uint64_t{0};
  std::uint32_t last = 0;
  std::vector<std::uint32_t> numbers;
  for (const auto& chunk : listed) {
    count += chunk.size();
  }
  numbers.reserve(count);
  for (const auto& chunk : listed) {
    for (const BlockRay& one : chunk) {
      if (one.block != last_key) {
        last_key = one.block;
        last = blocks_.index.add(one.block);
        checkMemory();
      }
      numbers.push_back(last);
    }
  }
  blocks_.blocks.resize(blocks_.index.size());

  std::vector<std::uint32_t> offsets(blocks_.blocks.size() + 1, 0), touched;
  for (const std::uint32_t number : numbers) {
    if (offsets[number + 1]++ == 0) {
      touched.push_back(number);
    }
  }
  for (std::size_t i = 1; i < offsets.size(); ++i) {
    offsets[i] += offsets[i - 1];
  }
  std::vector<std::uint32_t> sorted(count), place(offsets.begin(), offsets.end() - 1);
  std::size_t at = 0;
  for (const auto& chunk : listed) {
    for (const BlockRay& one : chunk) {
      sorted[place[numbers[at++]]++] = one.ray;
    }
  }
  // The longest work first, so that no thread is left alone with it.
  std::sort(touched.begin(), touched.end(), [&offsets](std::uint32_t a, std::uint32_t b) {
    return offsets[a + 1] - offsets[a] > offsets[b + 1] - offsets[b];
  });
  run.each(touched.size(), 1, 0.0, [&](std::size_t i) {
    const std::uint32_t number = touched[i];
    auto& block = blocks_.blocks[number];
    if (!block) {
      block = newBlock();
    }
    block->is_changed = true;
    for (std::uint32_t k = offsets[number]; k < offsets[number + 1]; ++k) {
      addToBlock(number, rays[sorted[k] % BATCH], sorted[k] & ~(ALONG - 1), measured);
    }
  });
}

void SignedDistanceField::addToBlock(std::uint32_t number, const Ray& ray, std::uint32_t parts,
                                     const MeasuredPoints& measured)
{
  VoxelBlock& block = *blocks_.blocks[number];
  const GridPlace place = GridPlace::of(blocks_.index.keys()[number]);
  const std::array<std::int32_t, 3> low = {place.x * BLOCK_SIDE, place.y * BLOCK_SIDE,
                                           place.z * BLOCK_SIDE};
  const std::array<std::int32_t, 3> high = {low[0] + BLOCK_SIDE, low[1] + BLOCK_SIDE,
                                            low[2] + BLOCK_SIDE};
  const float truncation = static_cast<float>(options_.truncation / options_.voxel_size);
  const float to_units = DISTANCE_UNITS / truncation;

  const auto voxelOf = [&low](const std::array<std::int32_t, 3>& cell) {
    return voxelInBlock(cell[0] - low[0], cell[1] - low[1], cell[2] - low[2]);
  };
  const auto average = [&](std::size_t voxel, float distance, float weight) {
    std::uint16_t& sum = block.weights[voxel];
    std::int16_t& mean = block.distances[voxel];
    const float units = weight * WEIGHT_UNITS, all = static_cast<float>(sum) + units;
    const float before = static_cast<float>(mean);
    mean = rounded<std::int16_t>(before + (distance * to_units - before) * (units / all));
    sum = std::max<std::uint16_t>(1, rounded<std::uint16_t>(std::min(all, MOST_UNITS)));
  };
  const auto measure = [&](const std::array<std::int32_t, 3>& cell) {
    const Vector3f from_point = {cell[0] + 0.5f - ray.point[0], cell[1] + 0.5f - ray.point[1],
                                 cell[2] + 0.5f - ray.point[2]};
    const float distance = dot(ray.normal, from_point);
    if (std::abs(distance) >= truncation) {
      return;
    }
    const float beside = dot(from_point, from_point) - distance * distance;
    float weight = ray.weight / (1 + beside);
    // The same on both sides: of distances that err, those that count less or not at all would else
    // draw the surface away from them.
    if (std::abs(distance) > 1) {
      weight *= (truncation - std::abs(distance)) / (truncation - 1);
    }
    const std::size_t voxel = voxelOf(cell);
    average(voxel, distance, weight);
    if (std::abs(distance) > 1 || beside > 1) {
      return;
    }
    std::uint16_t& seen = block.observations[voxel];
    const float share = 1.0f / static_cast<float>(std::min<unsigned>(seen, MOST_OF_COLOR) + 1);
    if (block.intensities && !measured.intensities.empty() &&
        std::isfinite(measured.intensities[ray.number])) {
      float& mean = (*block.intensities)[voxel];
      mean += share * (measured.intensities[ray.number] - mean);
    }
    if (block.colors && !measured.colors.empty()) {
      VoxelColor& color = (*block.colors)[voxel];
      const std::uint8_t* const value = measured.colors.data() + 3 * std::size_t{ray.number};
      const float part = 1.0f / static_cast<float>(color.count + 1);
      const float noise = noiseOf(ray.number, static_cast<std::uint32_t>(voxel));
      color.red = newMean(color.red, value[0], part, noise);
      color.green = newMean(color.green, value[1], part, noise);
      color.blue = newMean(color.blue, value[2], part, noise);
      color.count = static_cast<std::uint8_t>(std::min(color.count + 1u, MOST_OF_COLOR - 1));
    }
    seen = static_cast<std::uint16_t>(std::min(seen + 1, 65535));
  };
  if ((parts & ALONG) != 0) {
    visitCells(ray.front, ray.back, low, high, measure);
  }
  if ((parts & ACROSS) != 0) {
    visitCells(ray.outside, ray.inside, low, high, measure);
  }
  if ((parts & CARVED) != 0) {
    const Vector3f way = along(ray.front, -1, ray.sensor);
    const float length = std::sqrt(dot(way, way));
    if (length > truncation) {
      visitCells(ray.sensor, ray.front, low, high, [&](const std::array<std::int32_t, 3>& cell) {
        const Vector3f from_front = {cell[0] + 0.5f - ray.front[0], cell[1] + 0.5f - ray.front[1],
                                     cell[2] + 0.5f - ray.front[2]};
        const float ahead = dot(from_front, way) / length;
        const std::size_t voxel = voxelOf(cell);
        if (dot(from_front, from_front) - ahead * ahead < CARVE_WIDTH * CARVE_WIDTH &&
            block.weights[voxel] > 0) {
          average(voxel, truncation, ray.weight * CARVE_WEIGHT);
        }
      });
    }
  }
}

}  // namespace mesh_map
