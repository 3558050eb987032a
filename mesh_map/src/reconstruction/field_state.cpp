#include "reconstruction/field_state.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/require.h"

namespace mesh_map {

FieldState<StateVector> fieldState(const VoxelBlocks& blocks, const SurfaceNormals& normals)
{
  FieldState<StateVector> state;
  state.cell_keys = normals.keys();
  state.cell_numbers = normals.numbers();
  for (std::size_t i = 0; i < blocks.blocks.size(); ++i) {
    const VoxelBlock* const block = blocks.blocks[i].get();
    if (block == nullptr) {  // of points that did not find room
      continue;
    }
    const auto append = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    state.keys.push_back(blocks.index.keys()[i]);
    for (const VoxelDistance& voxel : block->distances) {
      state.distances.push_back(voxel.distance());
      state.weights.push_back(voxel.weight());
    }
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

VoxelBlocks blocksOf(const FieldState<ArrayView>& state, bool colors, bool intensities)
{
  const std::size_t count = state.keys.size(), voxels = count * BLOCK_VOXELS;
  require(state.distances.size() == voxels && state.weights.size() == voxels &&
              state.observations.size() == voxels &&
              state.colors.size() == (colors ? 4 * voxels : 0) &&
              state.intensities.size() == (intensities ? voxels : 0),
          "the state of a field has other arrays than its options ask for");
  require(std::all_of(state.cell_numbers.begin(), state.cell_numbers.end(),
                      [](float number) { return std::isfinite(number); }),
          "the state of a field has numbers that are not finite");
  VoxelBlocks blocks;
  for (std::size_t i = 0; i < count; ++i) {
    require(state.keys[i] >> 63 == 0 && blocks.index.add(state.keys[i]) == i,
            "the state of a field has a block twice, or one that is nowhere");
    auto block = VoxelBlock::make(colors, intensities);
    const std::size_t first = i * BLOCK_VOXELS;
    for (std::size_t v = 0; v < BLOCK_VOXELS; ++v) {
      block->distances[v] = VoxelDistance::of(state.distances[first + v], state.weights[first + v]);
    }
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
  return blocks;
}

}  // namespace mesh_map
