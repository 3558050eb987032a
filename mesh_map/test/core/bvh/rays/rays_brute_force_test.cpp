#include <mesh_map/bvh/tree/bvh.h>

#include "ray_checks.h"
#include "ray_samples.h"

using mesh_map::Bvh;
using mesh_map::Ray;
using mesh_map::RayHit;
using mesh_map::RayOptions;

namespace {

// Brute force looks at every face: fewer rays for larger meshes.
std::size_t raysFor(const TestMesh& mesh)
{
  return std::max<std::size_t>(16, std::min<std::size_t>(600, 120000 / mesh.faceCount()));
}

TEST(Rays, answer_as_if_all_faces_had_been_asked)
{
  for (const TestMesh& mesh : testMeshes()) {
    const Bvh bvh = Bvh::build(mesh.view());
    const std::size_t hits = expectAsAllFaces(mesh, bvh, RaySamples(mesh).all(raysFor(mesh)));
    EXPECT_GT(hits, 0u) << mesh.name;
  }
}

TEST(Rays, pass_faces_that_are_seen_from_behind)
{
  for (const TestMesh& mesh : testMeshes()) {
    const Bvh bvh = Bvh::build(mesh.view());
    RayOptions options;
    options.back_faces = false;
    expectAsAllFaces(mesh, bvh, RaySamples(mesh, 2).all(raysFor(mesh) / 4), options);
  }
}

TEST(Rays, pass_faces_that_are_masked)
{
  for (const TestMesh& mesh : testMeshes()) {
    const Bvh bvh = Bvh::build(mesh.view());
    RaySamples samples(mesh, 3);
    std::vector<std::uint8_t> mask(mesh.faceCount());
    for (std::uint8_t& passed : mask) {
      passed = samples.index(3) == 0 ? 0 : static_cast<std::uint8_t>(samples.index(255) + 1);
    }
    RayOptions options;
    options.mask = mask;
    expectAsAllFaces(mesh, bvh, samples.all(raysFor(mesh) / 4), options);
    std::fill(mask.begin(), mask.end(), 0);
    EXPECT_EQ(expectAsAllFaces(mesh, bvh, samples.anywhere(16), options), 0u) << mesh.name;
  }
}

TEST(Rays, end_at_their_maximum_distance_and_hit_what_is_exactly_there)
{
  for (const TestMesh& mesh : testMeshes()) {
    const Bvh bvh = Bvh::build(mesh.view());
    Rays rays;
    std::size_t hits = 0;
    RaySamples samples(mesh, 4);
    for (Ray ray : samples.anywhere(raysFor(mesh))) {
      const RayHit hit = castAtAllFaces(mesh, ray);
      if (hit.face == mesh_map::NO_INDEX) {
        continue;
      }
      for (const double limit :
           {hit.distance, std::nextafter(hit.distance, 0.0), std::nextafter(hit.distance, 1e300)}) {
        ray.max_distance = limit;
        rays.push_back(ray);
      }
      ++hits;
    }
    EXPECT_GE(expectAsAllFaces(mesh, bvh, rays), 2 * hits) << mesh.name;
  }
}

TEST(Rays, hit_the_lowest_of_100000_identical_triangles)
{
  const TestMesh mesh = identical(100000);
  const Bvh bvh = Bvh::build(mesh.view());
  const Rays rays = {{{0.2, 0.2, 1.0}, {0.0, 0.0, -1.0}},
                     {{0.2, 0.2, -1.0}, {0.1, 0.0, 1.0}},
                     {{0.5, 0.5, 1.0}, {0.0, 0.0, -1.0}},
                     {{0.9, 0.9, 1.0}, {0.0, 0.0, -1.0}},
                     {{0.1, 0.1, 0.0}, {1.0, 0.0, 0.0}}};
  EXPECT_EQ(expectAsAllFaces(mesh, bvh, rays), 3u);
  EXPECT_EQ(mesh_map::castRay(bvh, rays[0]).face, 0u);
  std::vector<std::uint8_t> mask(mesh.faceCount(), 0);
  mask[777] = mask[99999] = 1;
  RayOptions options;
  options.mask = mask;
  EXPECT_EQ(mesh_map::castRay(bvh, rays[0], options).face, 777u);
}

TEST(Rays, hit_a_giant_triangle_and_the_tiny_ones_beside_it)
{
  const TestMesh mesh = withGiant(terrain(30));
  const Bvh bvh = Bvh::build(mesh.view());
  RaySamples samples(mesh, 5);
  EXPECT_GT(expectAsAllFaces(mesh, bvh, samples.all(40)), 0u);
  const Ray up = {{5.0, 5.0, -1.0}, {0.0, 0.0, 1.0}}, down = {{5.0, 5.0, -1.0}, {0.0, 0.0, -1.0}};
  EXPECT_LT(mesh_map::castRay(bvh, up).face, 1800u);
  EXPECT_EQ(mesh_map::castRay(bvh, down).face, 1800u);
  EXPECT_EQ(mesh_map::castRay(bvh, down).distance, 1.0);
}

TEST(Rays, of_numbers_that_underflow_see_no_more_than_others)
{
  const TestMesh mesh = cube(4);
  const Bvh bvh = Bvh::build(mesh.view());
  Rays rays;
  for (const double tiny : {5e-324, 1e-310, 1e-250, 1e-160, 1e-100, 1e-61, 1e-50, 1e-39, 1e-20}) {
    rays.push_back({{tiny, -0.0, 0.0}, {0.7, tiny, -0.6}});
    rays.push_back({{tiny, tiny, -1.0}, {tiny, -tiny, 1.0}});
    rays.push_back({{0.3, tiny, -tiny}, {0.7, -tiny, tiny}});
  }
  expectAsAllFaces(mesh, bvh, rays);
}

TEST(Rays, of_a_mesh_of_any_size_and_place_are_exact)
{
  for (const float scale : {1e-43f, 1e-40f, 1e-30f, 1e-12f, 1e6f, 1e15f, 1e20f, 1e36f}) {
    for (const float offset : {0.0f, 100.0f}) {
      TestMesh mesh = soup(60);
      mesh.name += " times " + std::to_string(scale) + " moved by " + std::to_string(offset);
      for (float& position : mesh.positions) {
        position = scale * (position + offset);
      }
      const Bvh bvh = Bvh::build(mesh.view());
      EXPECT_GT(expectAsAllFaces(mesh, bvh, RaySamples(mesh).all(60)), 0u) << mesh.name;
    }
  }
}

}  // namespace
