#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "reconstruction/block_passages.h"
#include "reconstruction/field_input.h"
#include "reconstruction/measured_rays.h"
#include "reconstruction/voxel_blocks.h"

namespace mesh_map {

/// Puts what rays of a batch tell of voxels into their blocks, one block after the other: all that
/// is told of a voxel is summed up first, in the order of the points. Each thread has its own.
class VoxelUpdate
{
 public:
  /// What is given has to outlive it.
  VoxelUpdate(const FieldOptions& options, const MeasuredPoints& measured, const MeasuredRays& rays,
              const PassageLists& lists);

  void update(VoxelBlock& block, const GridPlace& place, const BlockPassages& passages);

 private:
  /// Sums over measurements of a voxel near their points.
  struct Seen
  {
    std::uint32_t count = 0, red = 0, green = 0, blue = 0;
    float intensities = 0, intensity_count = 0;
  };

  void measure(const BlockPassage& passage, const Vector3f& low);
  void carve(const BlockPassage& passage, const Vector3f& low, const VoxelBlock& block);
  void see(std::size_t voxel, std::size_t point);
  void store(VoxelBlock& block);
  void storeSeen(VoxelBlock& block, std::size_t voxel, const Seen& seen) const;

  const MeasuredPoints& measured_;
  const MeasuredRays& rays_;
  const PassageLists& lists_;
  float truncation_;  // voxels
  // Sums of weights, and of distances times weights, both in their units.
  alignas(16) std::array<float, BLOCK_VOXELS> weights_{}, distances_{};
  std::array<Seen, BLOCK_VOXELS> seen_{};
};

}  // namespace mesh_map
