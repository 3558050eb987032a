#pragma once

#include <malloc.h>

#include <cstddef>

namespace rviz_mesh_plugin {

/// From this size on malloc() maps each block on its own.
constexpr std::size_t LARGE_BLOCK = std::size_t{1} << 20;

/// Has malloc() give large blocks back to the system as soon as they are freed, by whichever
/// thread. By default it raises that limit to 32 MB as it meets larger ones: arrays of meshes then
/// lie in the arenas of all threads that load some, and of these little is ever given back. For the
/// whole process, and for good.
inline void giveLargeBlocksBack()
{
#ifdef M_MMAP_THRESHOLD
  static const int done = mallopt(M_MMAP_THRESHOLD, static_cast<int>(LARGE_BLOCK));
  static_cast<void>(done);
#endif
}

}  // namespace rviz_mesh_plugin
