#include <algorithm>

#include "bvh/rays/ray_packet.h"

#ifdef __x86_64__

// All headers come before, so that nothing that other files share is compiled for AVX2.
#pragma GCC push_options
#pragma GCC target("avx2")

namespace mesh_map {

namespace {

constexpr unsigned LANES = 8;
typedef float Lanes __attribute__((vector_size(32)));
typedef std::int32_t LaneInts __attribute__((vector_size(32)));

inline Lanes minimum(Lanes a, Lanes b)
{
  return _mm256_min_ps(a, b);
}

inline Lanes maximum(Lanes a, Lanes b)
{
  return _mm256_max_ps(a, b);
}

inline unsigned bits(LaneInts mask)
{
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<Lanes>(mask)));
}

#include "bvh/rays/ray_packet_body.h"

}  // namespace

const SearchRays SEARCH_RAYS_AVX2 = searchRays;

}  // namespace mesh_map

#pragma GCC pop_options

#else

namespace mesh_map {

const SearchRays SEARCH_RAYS_AVX2 = nullptr;

}  // namespace mesh_map

#endif
