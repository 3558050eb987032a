#ifndef MESH_MAP_SRC_CANCEL_FLAG_H
#define MESH_MAP_SRC_CANCEL_FLAG_H

#include <atomic>

namespace mesh_map {

/// Bound as _CancelFlag. May be set from any thread, before or while what it is given to runs.
struct CancelFlag
{
  std::atomic<bool> flag{false};
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_CANCEL_FLAG_H
