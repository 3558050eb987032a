#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace mesh_msgs_hdf5 {

/// Sets of the numbers below n, each its own at first (Tarjan and van Leeuwen, 1984: paths are
/// halved, the lower number becomes the root).
class DisjointSets
{
 public:
  explicit DisjointSets(std::size_t n) : parents_(n)
  {
    std::iota(parents_.begin(), parents_.end(), 0u);
  }

  std::uint32_t find(std::uint32_t i)
  {
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];
      i = parents_[i];
    }
    return i;
  }

  void join(std::uint32_t i, std::uint32_t j)
  {
    i = find(i);
    j = find(j);
    if (i < j) {
      parents_[j] = i;
    } else {
      parents_[i] = j;
    }
  }

 private:
  std::vector<std::uint32_t> parents_;
};

}  // namespace mesh_msgs_hdf5
