#pragma once

#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/geometry_identity.h"
#include "measurement/measurement.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// Measurements, in the order in which they were asked for. Surfaces are measured on a thread, one
/// after the other; nobody waits. A mesh is not kept alive: with it, what is being measured ends,
/// and its measurements are stale until the same mesh returns. To be used by one thread.
class MeasurementList
{
 public:
  /// @param changed is called after each change
  explicit MeasurementList(std::function<void()> changed);

  /// @param points in the frame of the mesh: two, or three and more for an area
  /// @return its number
  std::uint32_t add(MeasurementKind kind, const MeshDataConstPtr& mesh, const std::string& frame,
                    const std::string& display, const std::vector<SurfacePoint>& points);
  void remove(std::uint32_t number);
  void clear();

  const std::vector<Measurement>& all() const { return all_; }
  /// Null: there is none.
  const Measurement* find(std::uint32_t number) const;

  /// The meshes of a name that there are.
  using Meshes = std::function<std::vector<MeshDataConstPtr>(const std::string& uuid)>;
  /// To be called often: takes what has been measured, and looks which meshes are gone or back.
  void work(const Meshes& meshes);

  /// By which thread the last one was measured.
  std::thread::id measuredBy() const { return measured_by_; }

 private:
  struct Outcome
  {
    MeasuredSurface surface;
    std::thread::id thread;
  };

  bool follow(std::size_t i, const std::vector<MeshDataConstPtr>& meshes);
  bool takeResult();
  bool startNext();

  std::function<void()> changed_;
  std::vector<Measurement> all_;
  std::vector<GeometryIdentity> identities_;  ///< as many: of their meshes
  std::uint32_t last_number_ = 0;
  std::uint32_t measured_ = 0;  ///< the one that is being measured; 0: none
  BackgroundTask<Outcome> task_{"measurements"};
  std::thread::id measured_by_;
};

}  // namespace rviz_mesh_plugin
