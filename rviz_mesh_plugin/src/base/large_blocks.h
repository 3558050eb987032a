#pragma once

#include <malloc.h>

#include <cstddef>

namespace rviz_mesh_plugin {

/// From this size on malloc() maps each block on its own.
constexpr std::size_t LARGE_BLOCK = std::size_t{4} << 20;

/// So much free space at its end an arena keeps.
constexpr std::size_t KEPT_SPACE = std::size_t{16} << 20;

/// Has malloc() give large blocks back to the system as soon as they are freed, by whichever
/// thread. By default it raises that limit to 32 MB as it meets larger ones: arrays of meshes then
/// lie in the arenas of all threads that load some, and of these little is ever given back.
///
/// For the whole process, of RViz and all its plugins, and for good: what is set no longer follows
/// what the process allocates. Blocks of medium size, and what is allocated again and again, stay
/// in the arenas, which else would be grown and cut with each of them.
inline void giveLargeBlocksBack()
{
#ifdef M_MMAP_THRESHOLD
  static const int done = mallopt(M_MMAP_THRESHOLD, static_cast<int>(LARGE_BLOCK)) &
                          mallopt(M_TRIM_THRESHOLD, static_cast<int>(KEPT_SPACE));
  static_cast<void>(done);
#endif
}

}  // namespace rviz_mesh_plugin
