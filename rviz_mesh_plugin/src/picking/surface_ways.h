#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/mesh_data.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

struct SurfacePoint
{
  std::uint32_t face = 0;
  std::array<double, 3> position{};  ///< in the face, in the coordinates of the mesh
};

struct SurfaceWay
{
  bool connected = false;      ///< false: there is no way, nor length
  double length = 0.0;         ///< in meters
  std::vector<double> points;  ///< 3 each, from start to end; straight in between
};

/// The way that a wave front takes over the surface of a mesh, pulled taut: no way near it is
/// shorter, and it is the shortest of all but for those that hardly differ. It crosses seams, where
/// vertices in the same place are several. Takes about a second for some million faces, and about
/// 200 bytes for each of them.
/// @throw Cancelled (cancellation.h), std::bad_alloc, std::invalid_argument for points that are not
/// in their faces
SurfaceWay findWay(const MeshData& mesh, const SurfacePoint& from, const SurfacePoint& to,
                   const std::atomic<bool>* cancel = nullptr);

/// Finds a way over a surface on a thread. To be used by one thread.
class WayMeasurement
{
 public:
  WayMeasurement() = default;
  ~WayMeasurement() { cancel(); }
  WayMeasurement(const WayMeasurement&) = delete;
  WayMeasurement& operator=(const WayMeasurement&) = delete;

  /// Gives up the one before. @throw std::bad_alloc, std::system_error
  void start(const MeshDataConstPtr& mesh, const SurfacePoint& from, const SurfacePoint& to);

  /// The way or why there is none, once.
  std::optional<BackgroundTask<SurfaceWay>::Outcome> take() { return task_.take(); }

  void cancel();

 private:
  std::shared_ptr<std::atomic<bool>> cancelled_;  ///< of the task
  BackgroundTask<SurfaceWay> task_;
};

}  // namespace rviz_mesh_plugin
