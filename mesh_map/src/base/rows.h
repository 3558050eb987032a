#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// Sorts items into rows, side by side in `values`. `visit(put)` calls put(row, item) for each of
/// them, the same in both of two passes. Rows keep the order of their items. Returns the offsets of
/// the rows.
template <class Values, class Visit>
std::vector<std::uint32_t> fillRows(std::size_t row_count, Values& values, const Visit& visit)
{
  // Filling moves each row's end; offset i + 2 is counted, so that offset i + 1 ends up as the end
  // of row i.
  std::vector<std::uint32_t> offsets(row_count + 2, 0);
  std::uint32_t* const ends = offsets.data() + 1;
  visit([ends](std::size_t row, const auto&) { ++ends[row + 1]; });
  for (std::size_t row = 1; row <= row_count; ++row) {
    ends[row] += ends[row - 1];
  }
  values.resize(ends[row_count]);
  visit([ends, &values](std::size_t row, const auto& item) { values[ends[row]++] = item; });
  offsets.pop_back();
  return offsets;
}

}  // namespace mesh_map
