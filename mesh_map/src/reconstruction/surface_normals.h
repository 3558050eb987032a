#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/run.h"
#include "reconstruction/key_index.h"

namespace mesh_map {

/// Which way the surface lies at a point, up to its sign: a unit normal, and how flat the points
/// around it are, from 0 (nothing is known, or an edge) to 1.
struct PointNormal
{
  float x = 0, y = 0, z = 0, flatness = 0;
};

/// Estimates normals of measured points from all points so far: by the covariance of those in the
/// cells around each (H. Hoppe et al.: Surface Reconstruction from Unorganized Points, 1992, 3.2).
/// Only sums of each cell are kept.
class SurfaceNormals
{
 public:
  /// cell_size: m; points within about one and a half of it have a say.
  explicit SurfaceNormals(double cell_size) : per_meter_(static_cast<float>(1 / cell_size)) {}

  static constexpr std::uint32_t NO_CELL = KeyIndex::NONE;

  /// Adds points (x, y, z each) and gives the cell of each. Where `is_used` is 0, a point is left
  /// out, and has none; all others are finite, and within the grid.
  std::vector<std::uint32_t> add(ArrayView<float> points, ArrayView<std::uint8_t> is_used,
                                 Run& run);
  /// At a point in a cell.
  const PointNormal& at(std::uint32_t cell) const { return cells_[cell].normal; }

  /// All that was summed up: the keys of cells, and NUMBERS for each.
  static constexpr std::size_t NUMBERS = 15;
  const std::vector<std::uint64_t>& keys() const { return index_.keys(); }
  std::vector<float> numbers() const;
  /// Goes on from there; all keys have to differ.
  void restore(ArrayView<std::uint64_t> keys, ArrayView<float> numbers);

  std::size_t memory() const { return index_.memory() + cells_.capacity() * sizeof(Cell); }

 private:
  /// Sums over the points of a cell, relative to its middle.
  struct Cell
  {
    float count = 0;
    float sum[3] = {0, 0, 0};
    float square[6] = {0, 0, 0, 0, 0, 0};  // xx, xy, xz, yy, yz, zz
    float count_before = 0;                // when the normal was computed; -1 while it is to be
    PointNormal normal;

    void add(const std::array<float, 3>& from_middle);
  };
  static_assert(sizeof(Cell) == NUMBERS * sizeof(float));

  std::vector<std::uint32_t> cellsOf(ArrayView<float> points, ArrayView<std::uint8_t> is_used,
                                     Run& run);
  void addSums(ArrayView<float> points, const std::vector<std::uint32_t>& cells, Run& run);
  GridPlace placeOf(const float* point) const;
  std::array<float, 3> fromMiddle(const float* point) const;
  PointNormal normalOf(std::uint32_t cell) const;

  float per_meter_;  // cells
  KeyIndex index_;
  std::vector<Cell> cells_;
};

}  // namespace mesh_map
