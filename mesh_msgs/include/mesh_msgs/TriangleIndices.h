#ifndef MESH_MSGS_TRIANGLE_INDICES_H
#define MESH_MSGS_TRIANGLE_INDICES_H

#include <mesh_msgs/MeshTriangleIndices.h>

namespace mesh_msgs {
/// The name of release 1.0.
template <typename Allocator>
using TriangleIndices_ = MeshTriangleIndices_<Allocator>;
using TriangleIndices = MeshTriangleIndices;
using TriangleIndicesPtr = MeshTriangleIndicesPtr;
using TriangleIndicesConstPtr = MeshTriangleIndicesConstPtr;
}  // namespace mesh_msgs

#endif
