#pragma once

#include <mesh_map/bvh/rays/bvh_rays.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/support/ray_hits.h"
#include "core/support/test_meshes.h"

/// What castRay() has to say: by asking RayTest for every face.
inline mesh_map::RayHit castAtAllFaces(const TestMesh& mesh, const mesh_map::Ray& ray,
                                       const mesh_map::RayOptions& options = {})
{
  const mesh_map::RayTest test(ray);
  mesh_map::RayHit best;
  float corners[9];
  for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
    if (!options.mask.empty() && options.mask[face] == 0) {
      continue;
    }
    for (std::size_t k = 0; k < 9; ++k) {
      corners[k] = mesh.corner(face, k / 3)[k % 3];
    }
    const mesh_map::RayHit hit = hitOf(test, corners, options.back_faces);
    if (hit.face != mesh_map::NO_INDEX && hit.distance < best.distance) {
      best = hit;
      best.face = face;
    }
  }
  return best;
}

inline std::string describe(const mesh_map::Ray& ray)
{
  char text[200];
  std::snprintf(text, sizeof(text),
                "ray from %.17g %.17g %.17g along %.17g %.17g %.17g, at most %g", ray.origin[0],
                ray.origin[1], ray.origin[2], ray.direction[0], ray.direction[1], ray.direction[2],
                ray.max_distance);
  return text;
}

inline void expectSame(const mesh_map::RayHit& hit, const mesh_map::RayHit& expected,
                       const std::string& what)
{
  EXPECT_EQ(hit.face, expected.face) << what;
  EXPECT_EQ(hit.distance, expected.distance) << what;
  EXPECT_EQ(hit.barycentric, expected.barycentric) << what;
}

/// The rays as flat arrays.
struct RayArrays
{
  explicit RayArrays(const std::vector<mesh_map::Ray>& rays)
  {
    for (const mesh_map::Ray& ray : rays) {
      origins.insert(origins.end(), ray.origin.begin(), ray.origin.end());
      directions.insert(directions.end(), ray.direction.begin(), ray.direction.end());
      max_distances.push_back(ray.max_distance);
    }
  }
  mesh_map::RayBatch batch() const { return {origins, directions, max_distances}; }

  std::vector<double> origins, directions, max_distances;
};

/// Every query with every ray: the answers have to be those of all faces, bit for bit. Returns how
/// many rays hit.
inline std::size_t expectAsAllFaces(const TestMesh& mesh, const mesh_map::Bvh& bvh,
                                    const std::vector<mesh_map::Ray>& rays,
                                    const mesh_map::RayOptions& options = {})
{
  const RayArrays arrays(rays);
  const mesh_map::RayHits hits = mesh_map::castRays(bvh, arrays.batch(), options);
  const std::vector<std::uint8_t> any = mesh_map::raysHitAny(bvh, arrays.batch(), options);
  std::size_t count = 0;
  for (std::size_t i = 0; i < rays.size() && !testing::Test::HasFailure(); ++i) {
    const std::string what = mesh.name + ", " + describe(rays[i]);
    const mesh_map::RayHit expected = castAtAllFaces(mesh, rays[i], options);
    const bool hit = expected.face != mesh_map::NO_INDEX;
    expectSame(mesh_map::castRay(bvh, rays[i], options), expected, what);
    expectSame(
        {hits.faces[i],
         hits.distances[i],
         {hits.barycentric[3 * i], hits.barycentric[3 * i + 1], hits.barycentric[3 * i + 2]}},
        expected, "batch: " + what);
    EXPECT_EQ(mesh_map::rayHitsAny(bvh, rays[i], options), hit) << what;
    EXPECT_EQ(any[i], hit ? 1 : 0) << "batch: " << what;
    count += hit ? 1 : 0;
  }
  return count;
}
