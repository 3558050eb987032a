#include "walk_start.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace mesh_map {

void checkWalk(const WalkMesh& mesh, const WalkOptions& options)
{
  if (!options.mask.empty() && options.mask.size() != mesh.mesh.faceCount()) {
    throw std::invalid_argument("the mask needs one entry per face");
  }
}

Vector3 ofSizeOne(const Vector3& direction)
{
  const double largest =
      std::max({std::abs(direction[0]), std::abs(direction[1]), std::abs(direction[2])});
  if (!(largest > 0.0) || !isFinite(direction)) {
    return direction;
  }
  const int exponent = -std::ilogb(largest);
  return {std::scalbn(direction[0], exponent), std::scalbn(direction[1], exponent),
          std::scalbn(direction[2], exponent)};
}

bool canStart(const WalkMesh& mesh, const WalkPose& start)
{
  constexpr double rounding = 1e-6;
  const std::array<double, 3>& weights = start.barycentric;
  const double sum = weights[0] + weights[1] + weights[2];
  return start.face < mesh.mesh.faceCount() && std::abs(sum - 1.0) <= rounding &&
         weights[0] >= -rounding && weights[1] >= -rounding && weights[2] >= -rounding &&
         isFinite(start.up);
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
  return dot(face.normal(), ofSizeOne(start.up)) < 0.0 ? longestSideFirst(mesh, start.face, true)
                                                       : face;
}

void beginTrace(WalkTrace* trace, const Vector3& point)
{
  if (trace != nullptr) {
    trace->points.assign(point.begin(), point.end());
    trace->faces.clear();
  }
}

}  // namespace mesh_map
