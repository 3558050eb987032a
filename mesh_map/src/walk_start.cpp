#include "walk_start.h"

#include <stdexcept>

namespace mesh_map {

void checkWalk(const WalkMesh& mesh, const WalkOptions& options)
{
  if (!options.mask.empty() && options.mask.size() != mesh.mesh.faceCount()) {
    throw std::invalid_argument("the mask needs one entry per face");
  }
}

bool canStart(const WalkMesh& mesh, const WalkPose& start)
{
  return start.face < mesh.mesh.faceCount() && isFinite(start.barycentric) && isFinite(start.up);
}

FlatFace longestSideFirst(const WalkMesh& mesh, std::uint32_t face, bool reversed)
{
  std::size_t first = 0;
  double longest = -1.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3 side = difference(position(mesh, cornerOf(mesh, face, (k + 1) % 3)),
                                    position(mesh, cornerOf(mesh, face, k)));
    if (dot(side, side) > longest) {
      longest = dot(side, side);
      first = k;
    }
  }
  return FlatFace(mesh, face, reversed ? (first + 1) % 3 : first, reversed);
}

FlatFace startFace(const WalkMesh& mesh, const WalkPose& start)
{
  const FlatFace face = longestSideFirst(mesh, start.face, false);
  return dot(face.normal(), start.up) < 0.0 ? longestSideFirst(mesh, start.face, true) : face;
}

void beginTrace(WalkTrace* trace, const Vector3& point)
{
  if (trace != nullptr) {
    trace->points.assign(point.begin(), point.end());
    trace->faces.clear();
  }
}

}  // namespace mesh_map
