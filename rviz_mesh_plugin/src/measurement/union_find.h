#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace rviz_mesh_plugin {

/// Which of some things belong together.
class UnionFind
{
 public:
  explicit UnionFind(std::size_t count) : parents_(count)
  {
    std::iota(parents_.begin(), parents_.end(), 0u);
  }
  /// The same for all that belong together.
  std::uint32_t find(std::uint32_t i)
  {
    while (parents_[i] != i) {
      i = parents_[i] = parents_[parents_[i]];
    }
    return i;
  }
  void unite(std::uint32_t a, std::uint32_t b) { parents_[find(a)] = find(b); }

 private:
  std::vector<std::uint32_t> parents_;
};

}  // namespace rviz_mesh_plugin
