#include <mesh_map/bvh/tree/back_end.h>

#include <atomic>
#include <limits>

namespace mesh_map {

namespace {

std::atomic<std::uint64_t> counters[BACK_ENDS][QUERIES];  // static: all 0 at first

std::atomic<std::uint64_t>& counter(BackEnd back_end, Query query)
{
  return counters[static_cast<std::size_t>(back_end)][static_cast<std::size_t>(query)];
}

constexpr std::size_t NEVER = std::numeric_limits<std::size_t>::max();

struct Thresholds
{
  std::size_t cpu, gpu;
};

/// In the order of Query. A device that is a CPU runs on the cores that the native queries have,
/// and took twice their time for rays (PoCL): it gets nothing, unless Python has measured that it
/// is faster (mesh_map.spatial.opencl.measurement). A picture of 100 x 80 rays, as of a
/// visible-first selection, goes to any GPU, which has to bring a verdict per face back over the
/// bus: that pays for large selections alone. A lasso has no kernel. The numbers of GPUs are
/// estimated.
constexpr Thresholds THRESHOLDS[] = {
    {NEVER, 4096},     // RAY
    {NEVER, 4096},     // CLOSEST_POINT
    {NEVER, 500'000},  // SPHERE
    {NEVER, 500'000},  // FRUSTUM
    {NEVER, NEVER},    // LASSO
};
static_assert(sizeof(THRESHOLDS) / sizeof(THRESHOLDS[0]) == QUERIES, "one row per query");

}  // namespace

void countQueries(BackEnd back_end, Query query, std::uint64_t count)
{
  counter(back_end, query).fetch_add(count, std::memory_order_relaxed);
}

std::uint64_t queryCount(BackEnd back_end, Query query)
{
  return counter(back_end, query).load(std::memory_order_relaxed);
}

std::size_t deviceThreshold(Query query, bool device_is_gpu)
{
  const Thresholds& row = THRESHOLDS[static_cast<std::size_t>(query)];
  return device_is_gpu ? row.gpu : row.cpu;
}

}  // namespace mesh_map
