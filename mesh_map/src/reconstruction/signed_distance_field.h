#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/run_options.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "reconstruction/surface_normals.h"
#include "reconstruction/voxel_blocks.h"

namespace mesh_map {

/// How a field is made. Lengths in m.
struct FieldOptions
{
  double voxel_size = 0.1;
  double truncation = 0.2;  ///< distances are kept up to it
  double min_range = 0.0, max_range = std::numeric_limits<double>::infinity();
  bool carve = false;  ///< what rays pass through is emptied again, up to where they end
  bool colors = false, intensities = false;
  std::size_t memory_limit = std::numeric_limits<std::size_t>::max();  ///< bytes
};

/// Points and from where they were measured, in the frame of the field.
struct MeasuredPoints
{
  ArrayView<float> points, origins;  ///< x, y, z each; origins of all points, or one for all
  ArrayView<std::uint8_t> colors;    ///< red, green, blue each, or none
  ArrayView<float> intensities;      ///< or none
};

/// What became of points.
struct IntegrationCounts
{
  std::size_t used = 0, not_finite = 0, too_near = 0, too_far = 0, outside = 0;
};

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
  struct Ray;
  struct BlockRay;

  void addRays(std::vector<Ray>& rays, const std::vector<PointNormal>& normals,
               const MeasuredPoints& measured, Run& run);
  void aim(Ray& ray, const PointNormal& normal) const;
  void listBlocks(const Ray& ray, std::uint32_t number, std::vector<BlockRay>& listed) const;
  void addToBlock(std::uint32_t number, const Ray& ray, std::uint32_t parts,
                  const MeasuredPoints& measured);
  std::size_t blockMemory() const;
  void checkMemory();
  std::unique_ptr<VoxelBlock> newBlock() const;

  FieldOptions options_;
  VoxelBlocks blocks_;
  SurfaceNormals normals_;
};

}  // namespace mesh_map
