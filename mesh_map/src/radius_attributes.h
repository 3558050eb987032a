#ifndef MESH_MAP_SRC_RADIUS_ATTRIBUTES_H
#define MESH_MAP_SRC_RADIUS_ATTRIBUTES_H

#include <mesh_map/array_view.h>
#include <mesh_map/large_array.h>
#include <mesh_map/radius_statistics.h>

#include <cstddef>
#include <cstdint>

namespace mesh_map {

/// What a radius pass reads of vertices, one array each, so that loops over them vectorize. Arrays
/// that what is wanted does not need are empty.
struct RadiusAttributes
{
  LargeArray<float> x, y, z;
  LargeArray<float> heights;
  LargeArray<std::uint32_t> angles;  // in fixed point
  LargeArray<float> normals;         // 3 each

  std::size_t size() const { return x.size(); }
};

/// Those of all vertices, the one of index order[i] in place i; without an order, of index i.
RadiusAttributes gatherAttributes(const RadiusQuery& query, ArrayView<std::uint32_t> order);

/// Writes the statistics of one vertex, given those around it.
class RadiusWriter
{
 public:
  /// `results` has to outlive this object.
  RadiusWriter(const RadiusQuery& query, RadiusStatistics& results);

  /// `members` are the places in `of` of the vertices around `center`, itself among them; v is its
  /// index in the results.
  void write(const RadiusAttributes& of, std::uint32_t center, ArrayView<std::uint32_t> members,
             std::size_t v) const;

 private:
  float* height_differences_;
  float* roughnesses_;
  float* ridges_;
  double ridge_units_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_RADIUS_ATTRIBUTES_H
