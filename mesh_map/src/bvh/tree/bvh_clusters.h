#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>

#include <cstdint>

#include "base/radix_sort.h"
#include "bvh/tree/bvh_frame.h"
#include "bvh/tree/bvh_split.h"

namespace mesh_map {

/// Faces in an order in which nearby ones follow each other, and runs of them that form clusters.
struct BvhClusters
{
  LargeArray<KeyedIndex> faces;
  LargeArray<std::uint32_t> begins;  ///< per cluster and at the end: position in `faces`
  LargeArray<BvhItem> items;         ///< per cluster
};

/// Divides sorted faces into cells of the curve with at most `largest` triangles, and appends the
/// begin of each. Cells that cannot be divided further and have more are divided into triangles, so
/// that something small and dense beside something large is not lumped together.
void appendCells(const KeyedIndex* faces, std::uint32_t begin, std::uint32_t end,
                 std::uint32_t largest, LargeArray<std::uint32_t>& begins);

/// Checks the mesh and finds its clusters. Throws std::invalid_argument for faces that are not
/// sound.
BvhClusters findClusters(const MeshView& mesh, const FaceSample& sample, const LocalFrame& frame,
                         Run& run, double share);

}  // namespace mesh_map
