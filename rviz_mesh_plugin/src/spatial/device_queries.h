#pragma once

#include <mesh_map/bvh/device/bvh_device.h>
#include <mesh_map/bvh/rays/bvh_rays.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "spatial/opencl_program.h"

namespace rviz_mesh_plugin {

/// Whether the arrays of a batch have the lengths that their count asks for (the native queries say
/// what they think of others).
inline bool consistent(const mesh_map::RayBatch& rays)
{
  const std::size_t count = rays.size(), limits = rays.max_distances.size();
  return rays.directions.size() == 3 * count &&
         (rays.origins.size() == 3 || rays.origins.size() == 3 * count) &&
         (limits <= 1 || limits == count);
}

/// The part of an array with `width` values per item, or of one that is the same for all items.
inline mesh_map::ArrayView<double> slice(mesh_map::ArrayView<double> values, std::size_t width,
                                         std::size_t begin, std::size_t end)
{
  return values.size() <= width
             ? values
             : mesh_map::ArrayView<double>(values.data() + width * begin, width * (end - begin));
}

inline mesh_map::RayBatch slice(const mesh_map::RayBatch& rays, std::size_t begin, std::size_t end)
{
  return {slice(rays.origins, 3, begin, end), slice(rays.directions, 3, begin, end),
          slice(rays.max_distances, 1, begin, end)};
}

inline void append(mesh_map::RayHits& hits, const mesh_map::RayHits& more)
{
  const auto add = [](auto& values, const auto& others) {
    values.insert(values.end(), others.begin(), others.end());
  };
  add(hits.faces, more.faces);
  add(hits.distances, more.distances);
  add(hits.barycentric, more.barycentric);
}

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
