#include <algorithm>

#include "bvh/rays/ray_packet.h"

namespace mesh_map {

namespace {

constexpr unsigned LANES = 4;
typedef Floats4 Lanes;

#include "bvh/rays/ray_packet_body.h"

}  // namespace

void searchRaysBaseline(const Bvh& bvh, const RayOptions& options, bool any, RaySearch* rays,
                        std::size_t count)
{
  searchRays(bvh, options, any, rays, count);
}

SearchRays fastestSearchRays()
{
#ifdef __x86_64__
  if (SEARCH_RAYS_AVX2 != nullptr && __builtin_cpu_supports("avx2")) {
    return SEARCH_RAYS_AVX2;
  }
#endif
  return searchRaysBaseline;
}

}  // namespace mesh_map
