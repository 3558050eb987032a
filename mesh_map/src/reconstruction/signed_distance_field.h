#pragma once

#include <mesh_map/base/run_options.h>

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "reconstruction/field_input.h"
#include "reconstruction/field_state.h"
#include "reconstruction/measured_rays.h"
#include "reconstruction/surface_normals.h"
#include "reconstruction/voxel_blocks.h"

namespace mesh_map {

/// Thrown before a field would need much more memory than it may: by some MB more than it may.
class FieldMemoryError : public std::runtime_error
{
 public:
  explicit FieldMemoryError(std::size_t needed)
      : std::runtime_error("the field needs more memory than its limit"), needed(needed)
  {
  }
  std::size_t needed;  ///< bytes
};

/// A truncated signed distance field in blocks of voxels, made where surfaces were measured
/// (B. Curless and M. Levoy: A Volumetric Method for Building Complex Models from Range Images,
/// 1996; blocks in a hash table: M. Niessner et al.: Real-time 3D Reconstruction at Scale using
/// Voxel Hashing, 2013).
///
/// A ray changes the voxels along it near its end, and those across the surface there: each by its
/// distance to the plane through the point, whose normal is estimated of all points so far. Where
/// none is known, that plane stands across the ray. The result does not depend on the number of
/// threads, but on the order of the points.
class SignedDistanceField
{
 public:
  explicit SignedDistanceField(const FieldOptions& options);

  /// Adds points. Throws FieldMemoryError, Canceled (then some of the points may have been added).
  IntegrationCounts integrate(const MeasuredPoints& measured, const BvhOptions& run);

  /// For restore() of a field with the same options: it then goes on as this one would.
  FieldState<StateVector> state() const;
  /// Throws std::invalid_argument where it is none of such a field; then nothing has changed.
  void restore(const FieldState<ArrayView>& state);

  const FieldOptions& options() const { return options_; }
  const VoxelBlocks& blocks() const { return blocks_; }
  VoxelBlocks& blocks() { return blocks_; }
  std::size_t memory() const;

 private:
  void addRays(MeasuredRays& rays, const std::vector<std::uint32_t>& cells,
               const MeasuredPoints& measured, Run& run);
  std::size_t blockMemory() const;
  void checkMemory();

  FieldOptions options_;
  VoxelBlocks blocks_;
  SurfaceNormals normals_;
};

}  // namespace mesh_map
