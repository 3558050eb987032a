#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/bvh/tree/bvh_node.h>

#include <cstddef>
#include <cstdint>

#include "bvh/tree/bvh_frame.h"

namespace mesh_map {

class Run;

/// What a hierarchy takes from the positions of its mesh.
struct BvhGeometry
{
  const MeshView& mesh;
  const LocalFrame& frame;
  const std::uint32_t* faces;  ///< in the order of the leaves
  BvhNode* nodes;              ///< depth first, all but the boxes being right
  std::size_t node_count;
  float* corners;  ///< in the order of the leaves
};

/// Writes corners and boxes, on all threads.
void computeBoxes(const BvhGeometry& geometry, Run& run, double share);

/// The box around the children of a node.
FloatBox boxOf(const BvhNode& node);

/// Copies the corners of faces into the order of the leaves.
void copyCorners(const MeshView& mesh, const std::uint32_t* faces, std::size_t begin,
                 std::size_t end, float* corners);

}  // namespace mesh_map
