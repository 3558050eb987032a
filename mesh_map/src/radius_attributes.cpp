#include "radius_attributes.h"

#include <mesh_map/parallel.h>

#include <algorithm>
#include <cmath>

#include "fixed_point.h"

namespace mesh_map {
namespace {

constexpr std::size_t VERTICES_PER_CHUNK = 32768;

float heightDifference(const float* heights, std::uint32_t center, ArrayView<std::uint32_t> members)
{
  float lowest = heights[center], highest = lowest;
  for (const std::uint32_t u : members) {
    lowest = std::min(lowest, heights[u]);
    highest = std::max(highest, heights[u]);
  }
  return highest - lowest;
}

float roughness(const std::uint32_t* angles, ArrayView<std::uint32_t> members)
{
  std::uint64_t sum = 0;
  for (const std::uint32_t u : members) {
    sum += angles[u];
  }
  return meanOfFixed(sum, ANGLE_UNITS, members.size());
}

float ridge(const RadiusAttributes& of, std::uint32_t center, ArrayView<std::uint32_t> members,
            double units)
{
  const float *const x = of.x.data(), *const y = of.y.data(), *const z = of.z.data();
  const float* const normals = of.normals.data();
  const auto apart = [center, normals](const float* position, std::uint32_t u, unsigned axis) {
    return (double{position[u]} - position[center]) +
           (double{normals[3 * std::size_t{u} + axis]} - normals[3 * std::size_t{center} + axis]);
  };
  std::uint64_t sum = 0;
  for (const std::uint32_t u : members) {
    const double dx = apart(x, u, 0), dy = apart(y, u, 1), dz = apart(z, u, 2);
    sum += toFixed(std::sqrt(dx * dx + dy * dy + dz * dz), units);
  }
  return meanOfFixed(sum, units, members.size() - 1);  // its own distance is 0
}

double diagonal(ArrayView<float> positions)
{
  double squared = 0.0;
  for (std::size_t axis = 0; axis < 3 && !positions.empty(); ++axis) {
    float lowest = positions[axis], highest = lowest;
    for (std::size_t i = axis; i < positions.size(); i += 3) {
      lowest = std::min(lowest, positions[i]);
      highest = std::max(highest, positions[i]);
    }
    squared += (double{highest} - lowest) * (double{highest} - lowest);
  }
  return std::sqrt(squared);
}

/// Per meter. The tips of two normals are at most 2 m farther apart than the vertices; this leaves
/// room for twice as much.
double ridgeUnits(const RadiusQuery& query)
{
  const double largest = std::min(query.radius, diagonal(query.positions)) + 2.0;
  return std::exp2(std::floor(31.0 - std::log2(largest)));
}

}  // namespace

RadiusAttributes gatherAttributes(const RadiusQuery& query, ArrayView<std::uint32_t> order)
{
  const std::size_t count = query.positions.size() / 3;
  const bool heights = (query.wanted & HEIGHT_DIFFERENCE) != 0;
  const bool angles = (query.wanted & ROUGHNESS) != 0, normals = (query.wanted & RIDGE) != 0;
  RadiusAttributes all;
  all.x.resize(count);
  all.y.resize(count);
  all.z.resize(count);
  all.heights.resize(heights ? count : 0);
  all.angles.resize(angles ? count : 0);
  all.normals.resize(normals ? 3 * count : 0);
  parallelFor(count, VERTICES_PER_CHUNK, query.threads, [&]() -> RangeBody {
    return [&, up = query.up](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t v = order.empty() ? i : order[i];
        const float* const position = query.positions.data() + 3 * v;
        all.x[i] = position[0];
        all.y[i] = position[1];
        all.z[i] = position[2];
        if (heights) {
          all.heights[i] =
              static_cast<float>(position[0] * up[0] + position[1] * up[1] + position[2] * up[2]);
        }
        if (angles) {
          all.angles[i] = toFixed(query.angles[v], ANGLE_UNITS);
        }
        if (normals) {
          std::copy_n(query.normals.data() + 3 * v, 3, all.normals.data() + 3 * i);
        }
      }
    };
  });
  return all;
}

RadiusWriter::RadiusWriter(const RadiusQuery& query, RadiusStatistics& results)
    : height_differences_(query.wanted & HEIGHT_DIFFERENCE ? results.height_differences.data()
                                                           : nullptr),
      roughnesses_(query.wanted & ROUGHNESS ? results.roughnesses.data() : nullptr),
      ridges_(query.wanted & RIDGE ? results.ridges.data() : nullptr),
      ridge_units_(ridges_ == nullptr ? 1.0 : ridgeUnits(query))
{
}

void RadiusWriter::write(const RadiusAttributes& of, std::uint32_t center,
                         ArrayView<std::uint32_t> members, std::size_t v) const
{
  if (height_differences_ != nullptr) {
    height_differences_[v] = heightDifference(of.heights.data(), center, members);
  }
  if (roughnesses_ != nullptr) {
    roughnesses_[v] = roughness(of.angles.data(), members);
  }
  if (ridges_ != nullptr) {
    ridges_[v] = ridge(of, center, members, ridge_units_);
  }
}

}  // namespace mesh_map
