#pragma once

#include <mesh_map/base/parallel.h>

#include <cstddef>

namespace rviz_mesh_plugin {

/// Calls body(i) for all i below the count on all cores, each in runs of so many. The body is
/// copied into each run: capture pointers by value.
template <class Body>
void parallelEach(std::size_t count, const Body& body, std::size_t run = 65536)
{
  mesh_map::parallelFor(count, run, 0, [&body]() -> mesh_map::RangeBody {
    return [body](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        body(i);
      }
    };
  });
}

}  // namespace rviz_mesh_plugin
