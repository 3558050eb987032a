#include <mesh_map/neighborhood.h>
#include <mesh_map/parallel.h>
#include <mesh_map/radius_statistics.h>

#include <algorithm>
#include <cmath>

#include "radius_attributes.h"
#include "radius_blocks.h"

namespace mesh_map {
namespace {

constexpr double PI = 3.14159265358979323846;

void statisticsByEdges(const RadiusQuery& query, RadiusStatistics& results)
{
  constexpr std::size_t vertices_per_chunk = 4096;
  const RadiusAttributes attributes = gatherAttributes(query, {});
  const std::vector<PackedPosition> packed = packPositions(query.positions);
  const RadiusWriter writer(query, results);
  parallelFor(packed.size(), vertices_per_chunk, query.threads, [&]() -> RangeBody {
    return [neighborhood = RadiusNeighborhood(packed, query.neighbors), radius = query.radius,
            &attributes, writer](std::size_t begin, std::size_t end) mutable {
      for (std::size_t v = begin; v < end; ++v) {
        const auto center = static_cast<std::uint32_t>(v);
        writer.write(attributes, center, neighborhood.find(center, radius), v);
      }
    };
  });
}

/// The mean number of vertices around a vertex, itself included, of a sample of at least one.
double meanCount(const RadiusQuery& query)
{
  constexpr std::size_t samples = 48;
  const std::vector<PackedPosition> packed = packPositions(query.positions);
  RadiusNeighborhood neighborhood(packed, query.neighbors);
  const std::size_t taken = std::min(samples, packed.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < taken; ++i) {
    const std::size_t v = i * packed.size() / taken;
    sum +=
        static_cast<double>(neighborhood.find(static_cast<std::uint32_t>(v), query.radius).size());
  }
  return sum / static_cast<double>(taken);
}

/// Whether squared distances around this radius are far from the limits of single precision.
bool fitsGrid(double radius)
{
  return radius > 1e-15 && radius < 1e15;
}

}  // namespace

RadiusStatistics radiusStatistics(const RadiusQuery& query)
{
  const std::size_t count = query.positions.size() / 3;
  RadiusStatistics results;
  results.height_differences.resize(query.wanted & HEIGHT_DIFFERENCE ? count : 0);
  results.roughnesses.resize(query.wanted & ROUGHNESS ? count : 0);
  results.ridges.resize(query.wanted & RIDGE ? count : 0);
  if (query.search == RadiusSearch::EDGES || count == 0 || !fitsGrid(query.radius)) {
    statisticsByEdges(query, results);
    return results;
  }
  constexpr double enough_for_grid = 60.0;  // measured
  const double mean_count = meanCount(query);
  if (query.search == RadiusSearch::AUTOMATIC && mean_count < enough_for_grid) {
    statisticsByEdges(query, results);
  } else {
    // About as many vertices in a cell, however many are within the radius.
    constexpr double wanted_in_cell = 100.0, smallest = 0.125;
    const double share = std::sqrt(wanted_in_cell / std::max(mean_count, 1.0) * PI);
    const double cell_size = query.radius * std::clamp(share, smallest, 1.0);
    radiusStatisticsByGrid(query, cell_size, results);
  }
  return results;
}

}  // namespace mesh_map
