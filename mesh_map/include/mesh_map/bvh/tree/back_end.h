#pragma once

#include <cstddef>
#include <cstdint>

namespace mesh_map {

/// What answers a query.
enum class BackEnd
{
  NATIVE,
  OPENCL
};
constexpr std::size_t BACK_ENDS = 2;

enum class Query
{
  RAY,
  CLOSEST_POINT,
  SPHERE,
  FRUSTUM,  ///< boxes, too
  LASSO
};
constexpr std::size_t QUERIES = 5;

/// Counts queries that a back end has answered in this process: each ray or point of a batch is
/// one. Threads may call it at once.
void countQueries(BackEnd back_end, Query query, std::uint64_t count);
std::uint64_t queryCount(BackEnd back_end, Query query);

/// From how many queries of a batch on (rays, points; for selections: faces that may be touched) a
/// device is asked: the one place where that is decided, from measurements of
/// test/mesh_tools_test/benchmark/spatial_index.py. Never: the largest number there is.
std::size_t deviceThreshold(Query query, bool device_is_gpu);

}  // namespace mesh_map
