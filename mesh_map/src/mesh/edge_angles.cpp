#include "mesh/edge_angles.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <cmath>

#include "base/fixed_point.h"
#include "base/vector3.h"

namespace mesh_map {
namespace {

constexpr std::size_t ITEMS_PER_CHUNK = 16384;

double chordSquared(const float* a, const float* b, float sign)
{
  const double x = double{a[0]} - double{sign * b[0]};
  const double y = double{a[1]} - double{sign * b[1]};
  const double z = double{a[2]} - double{sign * b[2]};
  return x * x + y * y + z * z;
}

double angleOfChord(double squared)
{
  return 2.0 * std::asin(std::min(0.5 * std::sqrt(squared), 1.0));
}

}  // namespace

double angleBetween(const float* a, const float* b)
{
  const double squared = chordSquared(a, b, 1.0f);
  // The half of the circle in which the arc sine is well conditioned.
  return squared <= 2.0 ? angleOfChord(squared) : PI - angleOfChord(chordSquared(a, b, -1.0f));
}

std::vector<float> meanEdgeAngles(ArrayView<float> normals, ArrayView<std::uint32_t> edges,
                                  const RowsView& neighbor_edges, unsigned threads)
{
  std::vector<std::uint32_t> angles(edges.size() / 2);
  parallelEach(angles.size(), ITEMS_PER_CHUNK, threads, [=, out = angles.data()](std::size_t e) {
    out[e] = toFixed(angleBetween(normals.data() + 3 * std::size_t{edges[2 * e]},
                                  normals.data() + 3 * std::size_t{edges[2 * e + 1]}),
                     ANGLE_UNITS);
  });
  std::vector<float> means(neighbor_edges.rowCount());
  parallelEach(means.size(), ITEMS_PER_CHUNK, threads,
               [rows = neighbor_edges, from = angles.data(), out = means.data()](std::size_t v) {
                 const std::uint32_t* const offsets = rows.offsets.data();
                 std::uint64_t sum = 0;
                 for (std::uint32_t k = offsets[v]; k < offsets[v + 1]; ++k) {
                   sum += from[rows.values[k]];
                 }
                 out[v] = meanOfFixed(sum, ANGLE_UNITS, offsets[v + 1] - offsets[v]);
               });
  return means;
}

std::vector<float> anglesTo(ArrayView<float> normals, const std::array<double, 3>& direction,
                            unsigned threads)
{
  const std::array<float, 3> to = {static_cast<float>(direction[0]),
                                   static_cast<float>(direction[1]),
                                   static_cast<float>(direction[2])};
  std::vector<float> angles(normals.size() / 3);
  parallelEach(angles.size(), ITEMS_PER_CHUNK, threads,
               [normals, to, out = angles.data()](std::size_t v) {
                 out[v] = static_cast<float>(angleBetween(normals.data() + 3 * v, to.data()));
               });
  return angles;
}

}  // namespace mesh_map
