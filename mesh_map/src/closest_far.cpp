#include <algorithm>
#include <cmath>
#include <limits>

#include "closest_search.h"
#include "triangle_point.h"

namespace mesh_map {

namespace {

constexpr double INF = std::numeric_limits<double>::infinity();

}  // namespace

/// A subtree, and what is known of the distance to anything in it.
struct ClosestSearch::FarTask
{
  std::uint32_t child = 0;
  std::size_t first = 0, count = 0;
  double nearest = 0.0, farthest = 0.0;

  FarTask() = default;

  /// Of a box in local coordinates. Distances are computed by the same steps as those to triangles,
  /// and these never fall where a gap grows: no triangle seems nearer or farther than its box.
  FarTask(const Bvh& bvh, const double* point, const std::array<float, 3>& lower,
          const std::array<float, 3>& upper)
  {
    Vector3 near_gap{}, far_gap{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double center = bvh.center()[i];
      const double above = std::nextafter(center + lower[i], -INF) - point[i];
      const double below = point[i] - std::nextafter(center + upper[i], INF);
      near_gap[i] = std::max({above, below, 0.0});
      far_gap[i] = std::max(-above, -below);
    }
    nearest = lengthOf(near_gap);
    farthest = lengthOf(far_gap);
  }
};

bool ClosestSearch::allAsNear(const FarTask& task)
{
  if (task.nearest != task.farthest) {
    return false;
  }
  const std::size_t end = task.first + task.count;
  for (std::size_t i = task.first; i < end; ++i) {
    if (face_ == 0 && distance_ == task.nearest) {
      break;  // none is better
    }
    if (task.nearest < distance_ || bvh_.faces()[i] < face_) {
      offer(i);
    }
  }
  return true;
}

void ClosestSearch::searchFar()
{
  FarTask stack[BVH_STACK];
  std::size_t size = 0;
  FarTask root(bvh_, point_, bvh_.lower(), bvh_.upper());
  root.count = bvh_.faceCount();
  stack[size++] = root;
  while (size > 0) {
    const FarTask task = stack[--size];
    if (task.nearest > distance_ || allAsNear(task)) {
      continue;
    }
    if (isLeaf(task.child)) {
      for (std::size_t i = task.first; i < task.first + task.count; ++i) {
        offer(i);
      }
      continue;
    }
    const BvhNode& node = bvh_.nodes()[task.child];
    const std::size_t bottom = size;
    std::size_t first = task.first;
    for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
      if (node.child[k] == BVH_NO_CHILD) {
        continue;
      }
      FarTask child(bvh_, point_, {node.lower[0][k], node.lower[1][k], node.lower[2][k]},
                    {node.upper[0][k], node.upper[1][k], node.upper[2][k]});
      child.child = node.child[k];
      child.first = first;
      child.count = node.count[k];
      first += child.count;
      std::size_t place = size++;
      for (; place > bottom && stack[place - 1].nearest < child.nearest; --place) {
        stack[place] = stack[place - 1];
      }
      stack[place] = child;
    }
  }
}

}  // namespace mesh_map
