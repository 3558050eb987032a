#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/surface_ways.h"
#include "rviz_mesh_plugin/work_lanes.h"

namespace rviz_mesh_plugin {

/// Finds ways over surfaces on a thread, one after the other. To be used by one thread.
class WayMeasurement
{
 public:
  WayMeasurement() = default;
  ~WayMeasurement() { cancel(); }
  WayMeasurement(const WayMeasurement&) = delete;
  WayMeasurement& operator=(const WayMeasurement&) = delete;

  struct Result
  {
    SurfaceWay way;
    std::string failure;  ///< why there is none; else empty
  };

  /// Gives up the one before. @throw std::bad_alloc, std::system_error
  void start(const MeshDataConstPtr& mesh, const SurfacePoint& from, const SurfacePoint& to);

  /// The result, once.
  std::optional<Result> take();

  void cancel();

 private:
  struct Job;

  std::shared_ptr<Job> job_;
  WorkLanes lanes_;
};

}  // namespace rviz_mesh_plugin
