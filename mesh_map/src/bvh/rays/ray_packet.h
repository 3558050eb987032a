#pragma once

#include "bvh/rays/ray_search.h"

namespace mesh_map {

/// Searches many rays, some of which lie side by side and then go through the tree together. `any`:
/// stops at any hit of a ray.
using SearchRays = void (*)(const Bvh& bvh, const RayOptions& options, bool any, RaySearch* rays,
                            std::size_t count);

/// Four rays at a time, on any processor.
void searchRaysBaseline(const Bvh& bvh, const RayOptions& options, bool any, RaySearch* rays,
                        std::size_t count);

/// Eight rays at a time. Null where the compiler does not know AVX2.
extern const SearchRays SEARCH_RAYS_AVX2;

/// The fastest that this processor has.
SearchRays fastestSearchRays();

}  // namespace mesh_map
