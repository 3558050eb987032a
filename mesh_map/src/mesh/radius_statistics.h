#pragma once

#include <mesh_map/base/array_view.h>

#include <array>
#include <vector>

namespace mesh_map {

/// Bits of RadiusQuery::wanted.
enum RadiusStatistic : unsigned
{
  /// The largest minus the smallest height.
  HEIGHT_DIFFERENCE = 1,
  /// The mean of the angles (see normals.h).
  ROUGHNESS = 2,
  /// The mean distance of position + normal from that of the vertex itself, over the other
  /// vertices; 0 where there are none.
  RIDGE = 4,
  /// The same as the first two, without the vertex itself (see below where there is no other one).
  HEIGHT_DIFFERENCE_AROUND = 8,
  ROUGHNESS_AROUND = 16,
  /// Height differences over the surface of large faces, too (large_faces.h): of those at the
  /// vertex and at the ones around it, as far as they are within the radius.
  SURFACE_HEIGHT_DIFFERENCE = 32,
  SURFACE_HEIGHT_DIFFERENCE_AROUND = 64
};

/// How the vertices around a vertex are found. The results are the same, bit for bit.
enum class RadiusSearch
{
  /// For a few vertices beside each other at a time; in the order of a grid where it is large and
  /// many that are beside each other are far apart in the arrays.
  AUTOMATIC,
  /// From vertex to vertex along edges, for each vertex on its own.
  EDGES,
  /// For a few at a time, in the order of a grid.
  GRID
};

/// What to compute over N_r(v) (see neighborhood.h), with v itself or without, for every vertex v.
struct RadiusQuery
{
  ArrayView<float> positions;                  ///< 3 per vertex
  RowsView neighbors;                          ///< of each vertex, without itself
  ArrayView<std::uint32_t> faces;              ///< for both of the surface: 3 corners each,
  RowsView vertex_faces;                       ///< and those around each vertex
  ArrayView<float> angles;                     ///< for both roughnesses: one per vertex, 0 to pi
  ArrayView<float> normals;                    ///< for RIDGE: 3 per vertex, of length 1
  std::array<double, 3> up = {0.0, 0.0, 1.0};  ///< of length 1: heights are along it
  double radius = 0.0;                         ///< above 0
  unsigned wanted = 0;
  RadiusSearch search = RadiusSearch::AUTOMATIC;
  unsigned threads = 0;
};

/// One number per vertex for what was wanted; the others are empty.
struct RadiusStatistics
{
  std::vector<float> height_differences;
  std::vector<float> roughnesses;
  std::vector<float> ridges;
  std::vector<float> height_differences_around;
  std::vector<float> roughnesses_around;
  std::vector<float> surface_height_differences;
  std::vector<float> surface_height_differences_around;
};

/// All that is wanted in one pass. Sums are of whole numbers (of 2^-30 radians, and of less than
/// 2e-9 of the largest distance, of which each is known in single precision), so that the order of
/// the vertices does not matter. A vertex
/// without neighbors in reach has a height difference of 0; without itself none (NaN, unknown; -inf
/// in the released mesh_map), and a roughness of 0 (as released).
RadiusStatistics radiusStatistics(const RadiusQuery& query);

}  // namespace mesh_map
