#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace mesh_map {

/// Vertices in the cells of a regular grid, cells sorted by x, then y, then z.
class RadiusGrid
{
 public:
  /// A range of places in order().
  using Range = std::pair<std::uint32_t, std::uint32_t>;

  /// What lies far from most of the mesh shares the outermost cells.
  RadiusGrid(ArrayView<float> positions, double cell_size, unsigned threads);

  /// All vertices, cell by cell, ascending within each.
  const LargeArray<std::uint32_t>& order() const { return order_; }

  std::size_t cellCount() const { return cells_.size(); }
  Range cell(std::size_t cell) const { return {cells_[cell].first, end(cell)}; }

  /// Appends the cells, as ranges, that have all vertices within the radius of any vertex of this
  /// one (and others).
  void around(std::size_t cell, double radius, std::vector<Range>& found) const;

 private:
  using Coordinates = std::array<std::int32_t, 3>;

  struct Cell
  {
    Coordinates at;
    std::uint32_t first;                   // place in order_
    std::array<float, 3> lowest, highest;  // of its vertices
  };

  std::int32_t coordinate(double position, unsigned axis) const;
  void sort(ArrayView<float> positions, unsigned threads);
  void cut(ArrayView<float> positions, unsigned threads);
  std::uint32_t end(std::size_t cell) const
  {
    return cell + 1 < cells_.size() ? cells_[cell + 1].first
                                    : static_cast<std::uint32_t>(order_.size());
  }

  double cells_per_meter_;
  std::array<double, 3> origin_;
  LargeArray<std::uint32_t> order_;
  std::vector<Cell> cells_;
};

}  // namespace mesh_map
