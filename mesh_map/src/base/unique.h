#pragma once

#include <algorithm>
#include <vector>

namespace mesh_map {

/// Sorts values, and leaves each once.
template <class T>
void makeUnique(std::vector<T>& values)
{
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace mesh_map
