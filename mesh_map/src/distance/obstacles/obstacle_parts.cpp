// Solving parts of the mesh side by side, and then what lies between them.

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "distance/obstacles/obstacle_propagation.h"

namespace mesh_map {
namespace {

constexpr std::size_t MAX_PARTS = 8;
constexpr std::size_t MIN_PART = 30000;

float coordinate(const PackedPosition& p, int axis)
{
  return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/// Where to cut a mesh into parts of equal size across its longest axis.
struct Cuts
{
  int axis = 0;
  std::vector<float> places;  // ascending

  Cuts(const FastMarchingMesh& mesh, std::size_t parts)
  {
    const std::size_t step = mesh.vertexCount() / 4096 + 1;
    std::vector<float> best;
    for (int candidate = 0; candidate < 3; ++candidate) {
      std::vector<float> values;
      for (std::size_t v = 0; v < mesh.vertexCount(); v += step) {
        values.push_back(coordinate(mesh.position(static_cast<std::uint32_t>(v)), candidate));
      }
      std::sort(values.begin(), values.end());
      if (!values.empty() &&
          (best.empty() || values.back() - values.front() > best.back() - best.front())) {
        best = values;
        axis = candidate;
      }
    }
    for (std::size_t i = 1; i < parts; ++i) {
      places.push_back(best[i * best.size() / parts]);
    }
  }

  std::uint32_t part(const PackedPosition& p) const
  {
    const float value = coordinate(p, axis);
    std::uint32_t result = 0;
    while (result < places.size() && value >= places[result]) {
      ++result;
    }
    return result;
  }

  bool isNear(const PackedPosition& p, double reach) const
  {
    const float value = coordinate(p, axis);
    return std::any_of(places.begin(), places.end(),
                       [&](float place) { return std::abs(double{value} - place) <= reach; });
  }
};

}  // namespace

bool ObstacleDistance::solveParts(const std::atomic<bool>* cancel, unsigned threads)
{
  const std::size_t count = mesh_->vertexCount();
  const std::size_t parts = std::max<std::size_t>(
      1,
      std::min({static_cast<std::size_t>(resolveThreads(threads)), MAX_PARTS, count / MIN_PART}));
  const Cuts cuts(*mesh_, parts);
  const std::uint8_t first = newStamps(parts);
  parallelEach(count, 16384, threads, [&](std::size_t v) {
    stamps_[v] = static_cast<std::uint8_t>(
        first + cuts.part(mesh_->position(static_cast<std::uint32_t>(v))));
  });
  // Each part as if there were nothing else ...
  std::atomic<bool> is_done{true};
  std::vector<std::function<void()>> jobs;
  for (std::uint32_t i = 0; i < parts; ++i) {
    jobs.push_back([&, i]() {
      const auto stamp = static_cast<std::uint8_t>(first + i);
      Propagation propagation(*this, stamp, false);
      for (std::size_t v = 0; v < count; ++v) {
        if (stamps_[v] == stamp && passesOn(static_cast<std::uint32_t>(v))) {
          propagation.start(static_cast<std::uint32_t>(v));
        }
      }
      if (!propagation.run(cancel)) {
        is_done = false;
      }
    });
  }
  parallelJobs(jobs, threads);
  if (!is_done || parts == 1) {
    return is_done;
  }
  // ... so the equation fails only within three edges of where parts meet, which is
  // within two of the seam.
  std::vector<std::uint32_t> seam;
  for (std::uint32_t v = 0; v < count; ++v) {
    bool is_seam = false;
    forNeighbors(*mesh_, v,
                 [&](std::uint32_t u) { is_seam = is_seam || stamps_[u] != stamps_[v]; });
    if (is_seam) {
      seam.push_back(v);
    }
  }
  newStamps(1);
  region_.clear();
  for (std::uint32_t v = 0; v < count; ++v) {
    if (cuts.isNear(mesh_->position(v), reach())) {
      addToRegion(v);
    }
  }
  growRegion(seam, 0.0, count);
  std::vector<std::uint32_t> changed;
  solveRegion(count, changed);
  return true;
}

}  // namespace mesh_map
