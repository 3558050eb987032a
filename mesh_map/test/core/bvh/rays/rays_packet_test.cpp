#include <mesh_map/bvh/tree/bvh.h>

#include "bvh/rays/ray_packet.h"
#include "ray_checks.h"
#include "ray_samples.h"

using mesh_map::Bvh;
using mesh_map::RayOptions;
using mesh_map::RaySearch;

namespace {

/// Every way of this processor to search many rays.
std::vector<mesh_map::SearchRays> waysToSearch()
{
  std::vector<mesh_map::SearchRays> ways = {mesh_map::searchRaysBaseline};
  if (mesh_map::fastestSearchRays() != ways[0]) {
    ways.push_back(mesh_map::fastestSearchRays());
  }
  return ways;
}

TEST(RayPackets, of_any_width_answer_as_single_rays_do)
{
  for (const TestMesh& mesh : {terrain(60), soup(3000, 0.05f), cube(8), withGiant(soup(300))}) {
    const Bvh bvh = Bvh::build(mesh.view());
    RaySamples samples(mesh);
    std::vector<std::uint8_t> mask(mesh.faceCount(), 1);
    for (std::size_t i = 0; i < mask.size(); i += 3) {
      mask[i] = 0;
    }
    for (std::size_t n = 0; n < 60; ++n) {
      // Narrow and wide pictures, and those along the axes, on planes of boxes.
      Rays rays = samples.picture(n % 3 == 0 ? 200 : 20, 2);
      for (const Rays& more : {samples.alongAxes(8), samples.throughEdges(8),
                               samples.fromAfar(1e7, 3), samples.limited(7)}) {
        rays.insert(rays.end(), more.begin(), more.end());
      }
      if (n % 2 == 0) {  // the same ray, side by side with small shifts
        mesh_map::Ray ray = rays[n];
        for (std::size_t i = 0; i < 16; ++i) {
          ray.origin[i % 3] += 1e-3 * samples.size() * samples.number(0, 1);
          rays.push_back(ray);
        }
      }
      RayOptions options;
      options.back_faces = n % 4 != 1;
      options.mask = n % 4 == 2 ? mesh_map::ArrayView<std::uint8_t>(mask)
                                : mesh_map::ArrayView<std::uint8_t>();
      for (const mesh_map::SearchRays search_rays : waysToSearch()) {
        for (const bool any : {false, true}) {
          std::vector<RaySearch> searches;
          for (const mesh_map::Ray& ray : rays) {
            searches.emplace_back(bvh, ray);
          }
          search_rays(bvh, options, any, searches.data(), searches.size());
          for (std::size_t i = 0; i < rays.size(); ++i) {
            const mesh_map::RayHit expected = castRay(bvh, rays[i], options);
            const std::string what = mesh.name + ", " + describe(rays[i]);
            if (any) {
              ASSERT_EQ(searches[i].best.face != mesh_map::NO_INDEX,
                        expected.face != mesh_map::NO_INDEX)
                  << what;
            } else {
              expectSame(searches[i].hit(), expected, what);
            }
          }
        }
      }
    }
  }
}

}  // namespace
