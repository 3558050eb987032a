#pragma once

#include <mesh_map/base/array_view.h>

#include <cstdint>
#include <vector>

#include "reconstruction/surface_normals.h"
#include "reconstruction/voxel_blocks.h"

namespace mesh_map {

/// All that a field holds, a row for each block (of BLOCK_VOXELS values; colors: four each), and
/// the cells of its normals. Options are not among it.
template <template <class> class Array>
struct FieldState
{
  Array<std::uint64_t> keys;
  Array<std::int16_t> distances;
  Array<std::uint16_t> weights, observations;
  Array<std::uint8_t> colors;
  Array<float> intensities;
  Array<std::uint64_t> cell_keys;
  Array<float> cell_numbers;
};
template <class T>
using StateVector = std::vector<T>;

FieldState<StateVector> fieldState(const VoxelBlocks& blocks, const SurfaceNormals& normals);

/// The blocks of a state, all marked as changed. Throws std::invalid_argument where it is none of a
/// field that keeps colors or intensities, or does not, as said.
VoxelBlocks blocksOf(const FieldState<ArrayView>& state, bool colors, bool intensities);

}  // namespace mesh_map
