#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>

#include "base/mesh_data.h"
#include "spatial/spatial_queries.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

class FaceNeighbors;

/// What answers geometric questions about meshes: made once per mesh, on a thread, and shared by
/// all who ask. Thread safe; nothing here waits.
///
/// A mesh is kept alive only while its arrays are copied; work for one that is gone is given up,
/// and what was made for it is dropped within a second (its last users may keep theirs).
class SurfaceIndex
{
 public:
  /// The one of this process. Never destroyed; it frees everything with the last user().
  static SurfaceIndex& instance();

  explicit SurfaceIndex(SpatialQueriesOptions options = {});
  ~SurfaceIndex();  ///< gives up its work, and waits for nothing
  SurfaceIndex(const SurfaceIndex&) = delete;
  SurfaceIndex& operator=(const SurfaceIndex&) = delete;

  struct State
  {
    std::shared_ptr<const SpatialQueries> queries;  ///< null: not ready yet, or it failed
    float progress = 0.0f;                          ///< 0 to 1
    std::string failure;                            ///< why there will be none; else empty
  };
  /// Of a mesh (not null); begins to make them where nobody has asked before.
  /// @throw std::bad_alloc, std::system_error where no thread can be started
  State find(const MeshDataConstPtr& mesh);

  struct NeighborState
  {
    std::shared_ptr<const FaceNeighbors> neighbors;  ///< null: not ready yet, or it failed
    std::string failure;                             ///< why there will be none; else empty
  };
  /// The same for which faces lie beside each other.
  NeighborState findNeighbors(const MeshDataConstPtr& mesh);

  /// Gives up all work and frees what was made.
  void clear();

  /// What is made is kept as long as somebody has one of these.
  std::shared_ptr<void> user();

  /// For whom there is something, or will be.
  std::size_t meshCount() const;
  /// How often work was given up because its mesh was gone.
  std::size_t givenUp() const;

 private:
  class Worker;
  std::shared_ptr<Worker> worker();

  const SpatialQueriesOptions options_;
  mutable std::mutex mutex_;
  std::shared_ptr<Worker> worker_;
  WorkThread thread_{"surface index"};
  std::weak_ptr<void> user_;
};

}  // namespace rviz_mesh_plugin
