#pragma once

#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/rays/bvh_rays.h>

#include <cstddef>
#include <cstdint>
#include <vector>

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

inline bool consistent(mesh_map::ArrayView<double> points, const mesh_map::ClosestOptions& options)
{
  const std::size_t normals = options.normals.size();
  return points.size() % 3 == 0 && (normals == 0 || normals == 3 || normals == points.size());
}

inline bool consistent(mesh_map::ArrayView<std::uint8_t> mask, const mesh_map::Bvh& bvh)
{
  return mask.empty() || mask.size() == bvh.faceCount();
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

inline mesh_map::ClosestOptions slice(const mesh_map::ClosestOptions& options, std::size_t begin,
                                      std::size_t end)
{
  mesh_map::ClosestOptions part = options;
  part.normals = slice(options.normals, 3, begin, end);
  return part;
}

template <class T>
void append(std::vector<T>& values, const std::vector<T>& more)
{
  values.insert(values.end(), more.begin(), more.end());
}

inline void append(mesh_map::RayHits& hits, const mesh_map::RayHits& more)
{
  append(hits.faces, more.faces);
  append(hits.distances, more.distances);
  append(hits.barycentric, more.barycentric);
}

inline void append(mesh_map::SurfaceHits& hits, const mesh_map::SurfaceHits& more)
{
  append(hits.faces, more.faces);
  append(hits.distances, more.distances);
  append(hits.positions, more.positions);
  append(hits.barycentric, more.barycentric);
}

/// How to run the items from `done` on of `count`: progress goes on where it was.
inline mesh_map::BvhOptions rest(const mesh_map::BvhOptions& run, std::size_t done,
                                 std::size_t count)
{
  mesh_map::BvhOptions part = run;
  if (run.progress && done > 0) {
    const double begin = static_cast<double>(done) / static_cast<double>(count);
    part.progress = [progress = run.progress, begin](double fraction) {
      progress(begin + (1.0 - begin) * fraction);
    };
  }
  return part;
}

}  // namespace rviz_mesh_plugin
