#ifndef MESH_MAP_SRC_BASE_RADIX_SORT_H
#define MESH_MAP_SRC_BASE_RADIX_SORT_H

#include <mesh_map/base/large_array.h>

#include <cstdint>

namespace mesh_map {

class Run;

/// A number to sort by, and what it belongs to.
struct KeyedIndex
{
  std::uint32_t key, index;
};

/// Sorts by key on all threads; equal keys stay in their order.
void sortByKey(LargeArray<KeyedIndex>& items, Run& run, double share);

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_BASE_RADIX_SORT_H
