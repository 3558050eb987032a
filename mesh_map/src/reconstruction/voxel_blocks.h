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

/// Signed distance to the surface as a share of the truncation, and the weight of what it is the
/// mean of: 0 where nothing was measured. In one word, for both change together.
struct VoxelDistance
{
  std::uint32_t bits = 0;

  static VoxelDistance of(std::int16_t distance, std::uint16_t weight)
  {
    return {std::uint32_t{weight} << 16 | static_cast<std::uint16_t>(distance)};
  }
  std::int16_t distance() const { return static_cast<std::int16_t>(bits & 0xFFFF); }
  std::uint16_t weight() const { return static_cast<std::uint16_t>(bits >> 16); }
};

/// 8^3 voxels. Values of a voxel stand at its middle, x running fastest.
struct VoxelBlock
{
  std::array<VoxelDistance, BLOCK_VOXELS> distances{};
  /// Rays that ended near the voxel.
  std::array<std::uint16_t, BLOCK_VOXELS> observations{};
  std::unique_ptr<std::array<VoxelColor, BLOCK_VOXELS>> colors;  ///< null: none are kept
  std::unique_ptr<std::array<float, BLOCK_VOXELS>> intensities;
  bool is_changed = false;  ///< since its surface was extracted

  /// Where nothing was measured; with colors and intensities or without.
  static std::unique_ptr<VoxelBlock> make(bool colors, bool intensities)
  {
    auto block = std::make_unique<VoxelBlock>();
    if (colors) {
      block->colors = std::make_unique<std::array<VoxelColor, BLOCK_VOXELS>>();
    }
    if (intensities) {
      block->intensities = std::make_unique<std::array<float, BLOCK_VOXELS>>();
    }
    return block;
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

/// Of the key of a voxel's GridPlace: the bits that say where in its block the voxel is.
constexpr std::uint64_t ONE_EACH = (std::uint64_t{1} << 42) | (1 << 21) | 1;
constexpr std::uint64_t WITHIN_BLOCK = ONE_EACH * (BLOCK_SIDE - 1);

/// The key of the block of a voxel, by the voxel's key.
constexpr std::uint64_t blockOf(std::uint64_t voxel)
{
  constexpr std::uint64_t LIMIT = GridPlace::LIMIT;
  return (voxel & ~WITHIN_BLOCK) / BLOCK_SIDE + ONE_EACH * (LIMIT - LIMIT / BLOCK_SIDE);
}

/// The place in its block of a voxel, by the voxel's key.
constexpr std::size_t voxelInBlock(std::uint64_t voxel)
{
  return (voxel & 7) | ((voxel >> 18) & (7 << 3)) | ((voxel >> 36) & (7 << 6));
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
