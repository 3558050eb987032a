#include <algorithm>

#include "bvh/rays/ray_packet.h"

#ifdef __x86_64__

// All headers come before, so that nothing that other files share is compiled for AVX2.
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

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

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif

#else

namespace mesh_map {

const SearchRays SEARCH_RAYS_AVX2 = nullptr;

}  // namespace mesh_map

#endif
