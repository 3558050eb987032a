#pragma once

#include <mesh_map/base/run_options.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "reconstruction/signed_distance_field.h"

namespace mesh_map {

/// A surface with what was averaged at its vertices; rows as in Python.
struct FieldSurface
{
  std::vector<float> vertices, normals;  ///< x, y, z each; normals towards where sensors were
  std::vector<std::uint32_t> faces;      ///< counter-clockwise seen from there
  std::vector<std::uint8_t> colors;      ///< red, green, blue each, or none
  std::vector<float> intensities;        ///< or none
  std::vector<float> observations;       ///< rays that ended near
};

/// The surface of a field, by marching cubes between the middles of voxels. What did not change is
/// kept: each time only blocks with changes, and those beside them, are made anew. A vertex belongs
/// to the block where its edge begins, and is the same whoever uses it.
class SurfaceExtraction
{
 public:
  /// The surface where all corners of a cube have at least `least_weight`. Marks all blocks as not
  /// changed. Throws Canceled; then nothing has changed.
  FieldSurface extract(SignedDistanceField& field, float least_weight, const BvhOptions& run);

 private:
  static constexpr std::size_t EDGES = 3 * BLOCK_VOXELS;

  /// Vertices and triangles of a block. A corner of a triangle is which of the eight blocks from
  /// this one upwards (bits x, y, z), and the vertex there: 3 * voxel + axis.
  struct BlockSurface
  {
    struct Vertex
    {
      std::array<float, 3> position, normal;
      std::array<std::uint8_t, 3> color;
      float intensity, observations;
    };
    std::vector<std::uint32_t> corners;
    std::array<std::uint64_t, EDGES / 64> used{};  ///< edges that have a vertex
    std::vector<Vertex> vertices;                  ///< in their order
    std::size_t first = 0;                         ///< among all vertices
  };

  void makeTriangles(const VoxelBlocks& blocks, std::uint32_t number, float least_weight);
  void makeVertices(const SignedDistanceField& field, std::uint32_t number);

  std::vector<BlockSurface> surfaces_;
  float least_weight_ = -1;
};

}  // namespace mesh_map
