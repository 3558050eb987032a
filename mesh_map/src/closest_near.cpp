#include <algorithm>
#include <cmath>
#include <limits>

#include "closest_leaf.h"
#include "closest_search.h"
#include "triangle_point.h"

namespace mesh_map {

namespace {

/// A subtree to be searched.
struct NearTask
{
  std::uint32_t child, count;
  float squared;  // at most the square of the distance to its box
};

}  // namespace

/// The query in floats, which only say what cannot be the nearest.
struct ClosestSearch::NearQuery
{
  SplitPoint split;     // in the coordinates of the mesh
  Vectors4 low, high;   // in those of the boxes, rounded down and up
  float rounding;       // of a distance, absolutely
  float reach;          // what is farther than this does not matter
  float squared_reach;  // the same for squares

  NearQuery(const Bvh& bvh, const double* point, double distance) : split(point)
  {
    double largest = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto local = static_cast<float>(point[i] - bvh.center()[i]);
      const float step = std::abs(local) * 0x1p-23f + 1e-30f;  // at least the next float
      low[i] = all4(local - step);
      high[i] = all4(local + step);
      largest = std::max(largest, std::abs(point[i]));
    }
    // SplitPoint::to() in each of three coordinates; and what underflows
    rounding = static_cast<float>(largest * 0x1p-45) + 1e-20f;
    limit(distance);
  }

  /// Distances and their squares come out of floats wrong by less than 2^-21 and 2^-20 of
  /// themselves, by 8 roundings of 2^-24; those of TrianglePoint by far less.
  void limit(double distance)
  {
    reach = std::numeric_limits<float>::max();
    squared_reach = reach;
    if (distance < 1e18) {
      reach = static_cast<float>(distance) * (1.0f + 0x1p-20f) + rounding;
      squared_reach = reach * reach * (1.0f + 0x1p-19f) + 1e-37f;
    }
  }

  /// Squares of the distances to the boxes of a node: at most the true ones, but for rounding.
  Floats4 squaredDistances(const BvhNode& node) const
  {
    Vectors4 gap;
    for (std::size_t i = 0; i < 3; ++i) {
      gap[i] = maximum(maximum(load4(node.lower[i]) - high[i], low[i] - load4(node.upper[i])),
                       Floats4{});
    }
    return dot(gap, gap);
  }
};

void ClosestSearch::searchLeaf(NearQuery& query, std::size_t first, unsigned count)
{
  const LeafTriangles triangles(corners(first), query.split);
  unsigned left =
      bits(triangles.squaredBoxDistances() <= all4(query.squared_reach)) & ((1u << count) - 1);
  if (left == 0) {
    return;
  }
  const Floats4 bounds = triangles.bounds();
  left &= ~bits(bounds > all4(query.reach));
  while (left != 0) {
    unsigned next = lowestBit(left);
    for (unsigned others = left & (left - 1); others != 0; others &= others - 1) {
      const unsigned other = lowestBit(others);
      next = bounds[other] < bounds[next] ? other : next;
    }
    offer(first + next);
    query.limit(distance_);
    left &= ~(1u << next) & ~bits(bounds > all4(query.reach));
  }
}

void ClosestSearch::searchNear()
{
  NearQuery query(bvh_, point_, distance_);
  const BvhNode* const nodes = bvh_.nodes().data();
  NearTask stack[BVH_STACK];
  std::size_t size = 0;
  NearTask task = {0, 0, 0.0f};
  for (;;) {
    while (!isLeaf(task.child)) {
      const BvhNode& node = nodes[task.child];
      const Floats4 squared = query.squaredDistances(node);
      // slots without a child are at infinity, beyond any reach
      unsigned left = bits(squared <= all4(query.squared_reach));
      if (left == 0) {
        task.count = 0;
        break;
      }
      alignas(16) float distances[BVH_WIDTH];
      std::memcpy(distances, &squared, sizeof(distances));
      unsigned k = lowestBit(left);
      task = {node.child[k], node.count[k], distances[k]};
      const std::size_t bottom = size;
      for (left &= left - 1; left != 0; left &= left - 1) {
        k = lowestBit(left);
        NearTask other = {node.child[k], node.count[k], distances[k]};
        if (other.squared < task.squared) {
          std::swap(other, task);
        }
        std::size_t place = size++;
        for (; place > bottom && stack[place - 1].squared < other.squared; --place) {
          stack[place] = stack[place - 1];
        }
        stack[place] = other;
      }
    }
    if (task.count > 0) {
      searchLeaf(query, task.child & ~BVH_LEAF, task.count);
    }
    do {
      if (size == 0) {
        return;
      }
      task = stack[--size];
    } while (task.squared > query.squared_reach);
  }
}

}  // namespace mesh_map
