#pragma once

#include <mesh_map/bvh/device/bvh_device.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "spatial/opencl_program.h"

namespace rviz_mesh_plugin {

/// Queries about one mesh on a device that holds it. Answers are those of the native queries to the
/// last bit. Throws cl::Error where the device fails, and what the native queries throw. Several
/// threads may query at once.
class DeviceQueries
{
 public:
  /// Why the mesh has no room on the device; empty if it has.
  static std::string refusal(const OpenClProgram& program, const mesh_map::Bvh& bvh);

  /// Uploads the mesh, which must stay. A device that is the processor itself reads it in place.
  DeviceQueries(std::shared_ptr<const OpenClProgram> program, const mesh_map::Bvh& bvh);

  /// Appends the hits of the rays in order: also those before an exception, for good. Looks at the
  /// cancel flag, but tells no progress.
  void castRays(const mesh_map::RayBatch& rays, const mesh_map::BvhOptions& run,
                mesh_map::RayHits& hits) const;

  /// Those that touch a SphereRegion or a ConvexRegion, in the subtrees of
  /// mesh_map::selectionRoots().
  std::vector<std::uint32_t> selectFaces(const mesh_map::Region& region,
                                         const std::vector<std::uint32_t>& roots,
                                         const mesh_map::BvhOptions& run) const;

 private:
  const std::shared_ptr<const OpenClProgram> program_;
  const mesh_map::Bvh& bvh_;
  cl::Buffer nodes_, corners_;
};

}  // namespace rviz_mesh_plugin
