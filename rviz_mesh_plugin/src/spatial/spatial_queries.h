#pragma once

#include <mesh_map/bvh/rays/bvh_rays.h>
#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/tree/back_end.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "spatial/opencl_session.h"

namespace rviz_mesh_plugin {

class DeviceQueries;

struct SpatialQueriesOptions
{
  std::string device;  ///< as MESH_TOOLS_OPENCL, which it overrides; see deviceWish()
  LogFunction log;     ///< none: silent
  std::string cache_folder = ProgramCache::defaultFolder();  ///< of compiled programs; "": none

  /// From which size of a batch on the device is asked, instead of mesh_map::deviceThreshold().
  std::optional<std::size_t> device_threshold;
};

/// Geometric questions about a mesh: single ones are answered natively, batches by an OpenCL device
/// where there is one, where it pays, and as soon as it has started. The first large batch uploads
/// the mesh to the device, which takes long: large ones are not for the GUI thread. The answer is
/// the same to the last bit, and so is what is thrown: see mesh_map/bvh_rays.h and bvh_selection.h.
///
/// Whatever goes wrong with OpenCL costs one warning and nothing else: from then on, and for the
/// rest of the query it happened in, answers are native. A device that did not start is not asked
/// again in this process; one that failed later is started anew for the next SpatialQueries.
///
/// One object per mesh, which all share: several threads may query at once, but not a child process
/// after fork(), in which drivers of OpenCL do not work.
class SpatialQueries
{
 public:
  /// Starts the device in a thread of its own, once per process. The hierarchy must not change:
  /// make another object after Bvh::refit(). Throws std::invalid_argument for no hierarchy.
  explicit SpatialQueries(std::shared_ptr<const mesh_map::Bvh> bvh,
                          const SpatialQueriesOptions& options = {});
  ~SpatialQueries();
  SpatialQueries(const SpatialQueries&) = delete;
  SpatialQueries& operator=(const SpatialQueries&) = delete;

  const mesh_map::Bvh& bvh() const { return *bvh_; }

  mesh_map::RayHit castRay(const mesh_map::Ray& ray,
                           const mesh_map::RayOptions& options = {}) const;

  /// These two look at the cancel flag, but tell no progress.
  mesh_map::RayHits castRays(const mesh_map::RayBatch& rays,
                             const mesh_map::BvhOptions& run = {}) const;
  std::vector<std::uint32_t> seenFaces(const mesh_map::Region& region,
                                       mesh_map::ArrayView<std::uint32_t> faces,
                                       const std::array<double, 3>& eye,
                                       const mesh_map::BvhOptions& run = {}) const;

  /// How many faces touch a region, at most: for a sphere or a convex region few more than do, for
  /// others all. Told natively, in microseconds.
  std::size_t mostFaces(const mesh_map::Region& region) const;

  /// Those that touch a region.
  std::vector<std::uint32_t> selectFaces(const mesh_map::Region& region,
                                         const mesh_map::BvhOptions& run = {}) const;

  /// Waits until the device has started or failed, and returns whether batches go to it.
  bool waitForDevice() const;

 private:
  std::shared_ptr<const OpenClProgram> paysOnDevice(mesh_map::Query query, std::size_t count) const;
  std::shared_ptr<const DeviceQueries> device(mesh_map::Query query, std::size_t count) const;
  void onDevice(mesh_map::Query query, std::size_t count,
                const std::function<void(const DeviceQueries&)>& ask) const;

  const std::shared_ptr<const mesh_map::Bvh> bvh_;
  const std::optional<std::size_t> device_threshold_;
  const std::shared_ptr<OpenClSession> session_;  ///< null: off
  mutable std::mutex mutex_;                      ///< of those below
  mutable std::shared_ptr<const DeviceQueries> device_;
  mutable bool refused_ = false;  ///< the device has no room for this mesh
};

}  // namespace rviz_mesh_plugin
