#pragma once

#include <mesh_map/bvh/rays/bvh_rays.h>

#include <cstddef>

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

}  // namespace rviz_mesh_plugin
