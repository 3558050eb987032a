#pragma once

#include <mesh_map/bvh/tree/bvh.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/support/test_meshes.h"

/// What is wrong with a tree; nothing if it is empty.
class BvhCheck
{
 public:
  BvhCheck(const mesh_map::Bvh& bvh, const TestMesh& mesh) : bvh_(bvh), mesh_(mesh) {}

  std::string operator()()
  {
    if (bvh_.faceCount() != mesh_.faceCount()) {
      return "number of faces";
    }
    checkTriangles();
    if (error_.empty()) {
      const Interval all = {bvh_.lower().data(), bvh_.upper().data(), 1};
      checkNode(0, 1, static_cast<std::uint32_t>(mesh_.faceCount()), all);
      expect(triangle_ == mesh_.faceCount(), "triangles left out");
      expect(next_node_ == bvh_.nodes().size(), "nodes left out");
    }
    return error_;
  }

  std::size_t depth() const { return depth_; }
  double fill() const { return static_cast<double>(triangle_) / static_cast<double>(leaves_); }

 private:
  /// A box: axis by axis, `stride` floats apart.
  struct Interval
  {
    const float *lower, *upper;
    std::size_t stride;

    float low(std::size_t axis) const { return lower[stride * axis]; }
    float high(std::size_t axis) const { return upper[stride * axis]; }
  };

  void expect(bool condition, const std::string& message)
  {
    if (!condition && error_.empty()) {
      error_ = message;
    }
  }

  void checkTriangles()
  {
    std::vector<bool> found(mesh_.faceCount());
    for (std::size_t i = 0; i < mesh_.faceCount(); ++i) {
      const std::uint32_t face = bvh_.faces()[i];
      expect(face < found.size() && !found[face], "a face twice, or none: " + std::to_string(face));
      if (!error_.empty()) {
        return;
      }
      found[face] = true;
      const std::vector<float> corners = mesh_.corners(face);
      expect(std::memcmp(corners.data(), bvh_.corners().data() + 9 * i, 36) == 0,
             "corners of face " + std::to_string(face));
    }
    float sum = 0.0f;
    for (std::size_t i = 0; i < mesh_map::Bvh::TAIL; ++i) {
      sum += std::abs(bvh_.corners().data()[bvh_.corners().size() + i]);
    }
    expect(sum == 0.0f, "tail");
  }

  /// Boxes are exactly as large as floats allow.
  void checkNode(std::uint32_t index, std::size_t level, std::uint32_t count, Interval outer)
  {
    depth_ = std::max(depth_, level);
    expect(level <= mesh_map::BVH_DEPTH, "too deep");
    expect(index == next_node_++, "not depth first: node " + std::to_string(index));
    expect(index < bvh_.nodes().size(), "no such node: " + std::to_string(index));
    if (!error_.empty()) {
      return;
    }
    const mesh_map::BvhNode& node = bvh_.nodes()[index];
    std::uint64_t sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      expect(*std::min_element(node.lower[axis], node.lower[axis] + 4) == outer.low(axis) &&
                 *std::max_element(node.upper[axis], node.upper[axis] + 4) == outer.high(axis),
             "box of node " + std::to_string(index));
    }
    for (std::size_t k = 0; k < mesh_map::BVH_WIDTH; ++k) {
      sum += node.count[k];
      const Interval box = {node.lower[0] + k, node.upper[0] + k, mesh_map::BVH_WIDTH};
      if (node.child[k] == mesh_map::BVH_NO_CHILD) {
        constexpr float INF = std::numeric_limits<float>::infinity();
        expect(node.count[k] == 0 && box.low(0) == INF && box.low(1) == INF && box.low(2) == INF &&
                   box.high(0) == -INF && box.high(1) == -INF && box.high(2) == -INF,
               "slot without a child");
      } else if (mesh_map::isLeaf(node.child[k])) {
        checkLeaf(node.child[k] & ~mesh_map::BVH_LEAF, node.count[k], box);
      } else {
        expect(node.count[k] > mesh_map::BVH_LEAF_SIZE, "a node for few triangles");
        expect(node.child[k] > index, "a child before its parent");
        checkNode(node.child[k], level + 1, node.count[k], box);
      }
    }
    expect(sum == count, "count of node " + std::to_string(index));
  }

  void checkLeaf(std::uint32_t first, std::uint32_t count, Interval box)
  {
    ++leaves_;
    expect(first == triangle_ && count > 0 && count <= mesh_map::BVH_LEAF_SIZE,
           "leaf from triangle " + std::to_string(first));
    triangle_ += count;
    for (std::size_t axis = 0; axis < 3 && error_.empty(); ++axis) {
      double low = INFINITY, high = -INFINITY;
      bool exact = true;  // all differences
      for (std::size_t i = 3 * std::size_t{first}; i < 3 * (std::size_t{first} + count); ++i) {
        const double corner = bvh_.corners()[3 * i + axis], center = bvh_.center()[axis];
        const double local = corner - center;
        exact = exact && local + center == corner && corner - local == center;
        low = std::min(low, local);
        high = std::max(high, local);
      }
      // Two units in the last place of a float at most, and none where a float is exact.
      const double slack = 2.5e-7;
      const auto fits = [slack, exact](double outer, double inner) {
        const bool is_float = exact && static_cast<double>(static_cast<float>(inner)) == inner;
        return outer >= inner && (outer - inner <= (is_float ? 0.0 : slack * std::abs(inner)) ||
                                  (std::isinf(outer) && std::abs(inner) > 3.4e38));
      };
      expect(fits(box.high(axis), high) && fits(-double{box.low(axis)}, -low),
             "box of the leaf from triangle " + std::to_string(first));
    }
  }

  const mesh_map::Bvh& bvh_;
  const TestMesh& mesh_;
  std::string error_;
  std::size_t depth_ = 0, leaves_ = 0;
  std::uint32_t next_node_ = 0, triangle_ = 0;
};

inline std::string whatIsWrong(const mesh_map::Bvh& bvh, const TestMesh& mesh)
{
  return BvhCheck(bvh, mesh)();
}

/// Bit for bit.
inline bool sameTree(const mesh_map::Bvh& a, const mesh_map::Bvh& b)
{
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
  };
  return same(a.nodes(), b.nodes()) && same(a.corners(), b.corners()) &&
         same(a.faces(), b.faces()) && same(a.center(), b.center()) && same(a.lower(), b.lower()) &&
         same(a.upper(), b.upper());
}
