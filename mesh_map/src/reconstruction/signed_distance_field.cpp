#include "reconstruction/signed_distance_field.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "base/require.h"
#include "reconstruction/block_passages.h"
#include "reconstruction/voxel_update.h"

namespace mesh_map {
namespace {

constexpr float CELL_VOXELS = 2.0f;     // side of the cells of normals
constexpr std::size_t BATCH = 1 << 16;  // points whose normals are estimated at once
constexpr std::size_t RAYS = PassageLists::RAYS;

}  // namespace

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

FieldState<StateVector> SignedDistanceField::state() const
{
  return fieldState(blocks_, normals_);
}

void SignedDistanceField::restore(const FieldState<ArrayView>& state)
{
  VoxelBlocks blocks = blocksOf(state, options_.colors, options_.intensities);
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
  IntegrationCounts all;
  for (std::size_t begin = 0; begin < count; begin += BATCH) {
    const std::size_t end = std::min(count, begin + BATCH);
    MeasuredRays rays(options_, measured, begin, end);
    std::vector<std::uint8_t> is_used(rays.size());
    std::mutex mutex;
    run.loop(rays.size(), RAYS, 0.0, [&]() -> RangeBody {
      return [&](std::size_t first, std::size_t last) {
        const IntegrationCounts some = rays.make(first, last);
        for (std::size_t i = first; i < last; ++i) {
          is_used[i] = rays[i].weight > 0;
        }
        const std::lock_guard<std::mutex> lock(mutex);
        all += some;
      };
    });
    const ArrayView<float> points = {measured.points.data() + 3 * begin, 3 * (end - begin)};
    const std::vector<std::uint32_t> cells = normals_.add(points, is_used, run);
    checkMemory();
    addRays(rays, cells, measured, run);
  }
  return all;
}

void SignedDistanceField::addRays(MeasuredRays& rays, const std::vector<std::uint32_t>& cells,
                                  const MeasuredPoints& measured, Run& run)
{
  PassageLists lists(rays.size());
  run.each(lists.size(), 1, 0.0, [&](std::size_t number) {
    lists.list(number, rays, normals_, cells, blocks_.index, options_.carve);
  });
  const std::vector<BlockPassages> passages =
      lists.byBlock(blocks_.index, [this] { checkMemory(); });
  blocks_.blocks.resize(blocks_.index.size());
  run.loop(passages.size(), 1, 0.0, [&]() -> RangeBody {
    return [&, update = VoxelUpdate(options_, measured, rays, lists)](std::size_t begin,
                                                                      std::size_t end) mutable {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t number = passages[i].block;
        auto& block = blocks_.blocks[number];
        if (!block) {
          block = VoxelBlock::make(options_.colors, options_.intensities);
        }
        block->is_changed = true;
        update.update(*block, GridPlace::of(blocks_.index.keys()[number]), passages[i]);
      }
    };
  });
}

}  // namespace mesh_map
