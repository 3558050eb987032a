#include "bvh/selection/bvh_selection_filters.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/simd.h"
#include "bvh/selection/region_clip.h"

namespace mesh_map {

namespace {

/// Roundings of a float are 2^-24 of it. The sums below have less than 8.
constexpr double FLOAT_ROUNDING = 8.0 / 16777216.0;

constexpr double LARGEST_FLOAT = std::numeric_limits<float>::max();

/// A plane that all of a mesh which is much smaller is as clearly in front of, or behind, as of one
/// further away.
constexpr double FAR_AWAY = 1e37;

/// A float that is not smaller (larger).
float roundUp(double value)
{
  const double limited = std::min(LARGEST_FLOAT, std::max(-LARGEST_FLOAT, value));
  return std::nextafter(static_cast<float>(limited), std::numeric_limits<float>::infinity());
}

float roundDown(double value)
{
  return -roundUp(-value);
}

/// The size of coordinates in the hierarchy, relative to its center.
Vector3 localSize(const Bvh& bvh)
{
  Vector3 size;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size[axis] = std::max(std::abs(double{bvh.lower()[axis]}), std::abs(double{bvh.upper()[axis]}));
  }
  return size;
}

/// The box of a child in the coordinates of the mesh (rounded monotonously, so it still has its
/// triangles).
Box childBox(const Bvh& bvh, const BvhNode& node, std::size_t child)
{
  Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.lower[axis] = double{bvh.center()[axis]} + node.lower[axis][child];
    box.upper[axis] = double{bvh.center()[axis]} + node.upper[axis][child];
  }
  return box;
}

}  // namespace

SphereFilter::SphereFilter(const Bvh& bvh, const SphereRegion& sphere) : sphere_(sphere)
{
  const Vector3 size = localSize(bvh);
  double shift = 0.0, reach = 0.0;  // of the center by rounding; from it to the mesh at most
  bool near = sphere.valid();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double local = sphere.center()[axis] - bvh.center()[axis];
    near = near && std::abs(local) < 1e18;  // squares of floats do not overflow
    center_[axis] = near ? static_cast<float>(local) : 0.0f;
    shift += std::abs(local - center_[axis]);
    reach += size[axis] + std::abs(local);
  }
  // What triangle() rounds is less than 1e-14 of the distances in play. Squares of what is smaller
  // than the last number lose digits.
  const double rounding = shift + 1e-14 * reach + 1e-18;
  const double beyond = (sphere.radius() + rounding) * (1.0 + FLOAT_ROUNDING);
  const double within = (sphere.radius() - rounding) * (1.0 - FLOAT_ROUNDING);
  outside_ = near ? roundUp(beyond * beyond) : std::numeric_limits<float>::infinity();
  // Squares of what is smaller lose digits.
  inside_ = near && within > 1e-15 ? roundDown(within * within) : -1.0f;
}

void SphereFilter::children(const BvhNode& node, std::uint32_t, ChildSides& sides) const
{
  Floats4 near = all4(0.0f), far = all4(0.0f);  // squared distances
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Floats4 below = load4(node.lower[axis]) - center_[axis];
    const Floats4 above = center_[axis] - load4(node.upper[axis]);
    const Floats4 gap = maximum(maximum(below, above), all4(0.0f)), reach = maximum(-below, -above);
    near += gap * gap;
    far += reach * reach;
  }
  const Ints4 outside = near > all4(outside_), inside = far < all4(inside_);
  for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
    sides.side[k] = outside[k] != 0 || node.count[k] == 0 ? Side::OUTSIDE
                    : inside[k] != 0                      ? Side::INSIDE
                                                          : Side::TOUCHING;
    sides.cutting[k] = 0;
  }
}

ConvexFilter::ConvexFilter(const Bvh& bvh, const ConvexRegion& region) : region_(region)
{
  const Vector3 size = localSize(bvh);
  Vector3 largest;  // coordinates of the mesh
  for (std::size_t axis = 0; axis < 3; ++axis) {
    largest[axis] = size[axis] + std::abs(double{bvh.center()[axis]});
  }
  const bool large = !(size[0] + size[1] + size[2] < 0.1 * FAR_AWAY);  // nothing is sure in floats
  for (const Plane& plane : region.planes()) {
    const double local = height(plane, bvh.center()[0], bvh.center()[1], bvh.center()[2]);
    const double limited = std::min(FAR_AWAY, std::max(-FAR_AWAY, local));
    LocalPlane made;
    for (std::size_t i = 0; i < 3; ++i) {
      made.plane[i] = static_cast<float>(plane[i]);
    }
    made.plane[3] = static_cast<float>(limited);
    // Of `local`, and of triangle(); floats below 1e-37 (numbers, or parts of a normal) round by
    // more than their share.
    made.rounding = large ? std::numeric_limits<float>::infinity()
                          : roundUp(2.0 * HEIGHT_ROUNDING * heightTerms(plane, largest) +
                                    1e-37 * (1.0 + size[0] + size[1] + size[2]));
    planes_.push_back(made);
  }
}

void ConvexFilter::children(const BvhNode& node, std::uint32_t cutting, ChildSides& sides) const
{
  Floats4 lower[3], upper[3], largest[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    lower[axis] = load4(node.lower[axis]);
    upper[axis] = load4(node.upper[axis]);
    largest[axis] = maximum(-lower[axis], upper[axis]);
  }
  // Planes that no longer cut are masked (U. Assarsson, T. Moeller: Optimized View Frustum Culling
  // Algorithms, 2000).
  Ints4 outside{};
  Ints4 cut = Ints4{} + static_cast<std::int32_t>(cutting);
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    if ((cutting >> i & 1u) == 0) {
      continue;
    }
    const std::array<float, 4>& plane = planes_[i].plane;
    Floats4 front = all4(plane[3]), back = front;  // heights of the box over the plane
    Floats4 terms = all4(std::abs(plane[3]));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool rises = plane[axis] >= 0.0f;
      front += plane[axis] * (rises ? upper[axis] : lower[axis]);
      back += plane[axis] * (rises ? lower[axis] : upper[axis]);
      terms += std::abs(plane[axis]) * largest[axis];
    }
    const Floats4 rounding = terms * static_cast<float>(FLOAT_ROUNDING) + planes_[i].rounding;
    outside |= front < -rounding;
    cut &= ~((back > rounding) & static_cast<std::int32_t>(1u << i));
  }
  for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
    sides.cutting[k] = static_cast<std::uint32_t>(cut[k]);
    sides.side[k] = outside[k] != 0 || node.count[k] == 0 ? Side::OUTSIDE
                    : cut[k] == 0                         ? Side::INSIDE
                                                          : Side::TOUCHING;
  }
}

LassoFilter::LassoFilter(const Bvh& bvh, const LassoRegion& lasso)
    : bvh_(bvh), lasso_(lasso), frustum_(bvh, lasso.frustum())
{
}

void LassoFilter::children(const BvhNode& node, std::uint32_t cutting, ChildSides& sides) const
{
  frustum_.children(node, cutting, sides);
  for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
    if (sides.side[k] != Side::OUTSIDE) {
      sides.side[k] = lasso_.boxInFrustum(childBox(bvh_, node, k), sides.side[k] == Side::INSIDE);
    }
  }
}

}  // namespace mesh_map
