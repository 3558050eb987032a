#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "reconstruction/key_index.h"

namespace mesh_map {

constexpr std::int32_t BLOCK_SIDE = 8;  // voxels
constexpr std::size_t BLOCK_VOXELS = 512;

/// Red, green, blue, and of how many points they are the mean (no more than some: newer ones
/// count).
struct VoxelColor
{
  std::uint8_t red = 0, green = 0, blue = 0, count = 0;
};

/// 8^3 voxels. Values of a voxel stand at its middle, x running fastest.
struct VoxelBlock
{
  /// Signed distance to the surface as a share of the truncation, and the weight of what it is the
  /// mean of: 0 where nothing was measured.
  std::array<std::int16_t, BLOCK_VOXELS> distances{};
  std::array<std::uint16_t, BLOCK_VOXELS> weights{};
  /// Rays that ended near the voxel.
  std::array<std::uint16_t, BLOCK_VOXELS> observations{};
  std::unique_ptr<std::array<VoxelColor, BLOCK_VOXELS>> colors;  ///< null: none are kept
  std::unique_ptr<std::array<float, BLOCK_VOXELS>> intensities;
  bool is_changed = false;  ///< since its surface was extracted

  std::size_t memory() const
  {
    return sizeof(VoxelBlock) + (colors ? sizeof(*colors) : 0) +
           (intensities ? sizeof(*intensities) : 0);
  }
};

constexpr float DISTANCE_UNITS = 32767.0f;  // of distances, per truncation
constexpr float WEIGHT_UNITS = 128.0f;
constexpr float MOST_WEIGHT = 500.0f;  // newer measurements count at least so much less

/// The place of a voxel in its block.
constexpr std::size_t voxelInBlock(std::int32_t x, std::int32_t y, std::int32_t z)
{
  return static_cast<std::size_t>(x + BLOCK_SIDE * (y + BLOCK_SIDE * z));
}

/// Blocks by their place, numbered in the order in which they came.
struct VoxelBlocks
{
  KeyIndex index;
  std::vector<std::unique_ptr<VoxelBlock>> blocks;  ///< null: nothing was measured there yet

  const VoxelBlock* at(const GridPlace& place) const
  {
    const std::uint32_t number = place.isInside() ? index.find(place.key()) : KeyIndex::NONE;
    return number < blocks.size() ? blocks[number].get() : nullptr;
  }
};

}  // namespace mesh_map
