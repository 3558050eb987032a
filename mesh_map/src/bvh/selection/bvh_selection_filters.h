#pragma once

#include <mesh_map/bvh/selection/region.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <array>
#include <cstdint>
#include <vector>

/// What a traversal asks a region about the four children of a node at once, in floats that are
/// local to the hierarchy, with bounds of what these round. A filter may say TOUCHING of any child;
/// what else it says holds for Region::triangle() of every triangle there.
///
/// Each node has planes that may cut it: below one that a plane contains, it is not asked again.
namespace mesh_map {

static_assert(BVH_WIDTH == 4, "one vector per node");

/// How the children of a node lie to a region, and which planes may cut them.
struct ChildSides
{
  std::array<Side, BVH_WIDTH> side;
  std::array<std::uint32_t, BVH_WIDTH> cutting;
};

class SphereFilter
{
 public:
  SphereFilter(const Bvh& bvh, const SphereRegion& sphere);
  static std::uint32_t cutting() { return 0; }
  void children(const BvhNode& node, std::uint32_t cutting, ChildSides& sides) const;
  Side triangle(const float* corners, std::uint32_t) const { return sphere_.triangle(corners); }

 private:
  const SphereRegion& sphere_;
  std::array<float, 3> center_;
  float outside_, inside_;  // squared radii beyond and within which it is sure
};

class ConvexFilter
{
 public:
  ConvexFilter(const Bvh& bvh, const ConvexRegion& region);
  std::uint32_t cutting() const { return (1u << planes_.size()) - 1u; }
  void children(const BvhNode& node, std::uint32_t cutting, ChildSides& sides) const;
  Side triangle(const float* corners, std::uint32_t cutting) const
  {
    return region_.triangle(corners, cutting);
  }

 private:
  struct LocalPlane
  {
    std::array<float, 4> plane;
    float rounding;  // beside that of floats, which is relative to terms
  };
  const ConvexRegion& region_;
  std::vector<LocalPlane> planes_;
};

class LassoFilter
{
 public:
  LassoFilter(const Bvh& bvh, const LassoRegion& lasso);
  std::uint32_t cutting() const { return frustum_.cutting(); }
  void children(const BvhNode& node, std::uint32_t cutting, ChildSides& sides) const;
  Side triangle(const float* corners, std::uint32_t cutting) const
  {
    return lasso_.triangle(corners, cutting);
  }

 private:
  const Bvh& bvh_;
  const LassoRegion& lasso_;
  ConvexFilter frustum_;
};

}  // namespace mesh_map
