#pragma once

#include <mesh_map/bvh/rays/bvh_rays.h>

#include <array>

#include "base/simd.h"

namespace mesh_map {

/// A ray as 32-bit floats, made so that its tests let pass whatever RayTest hits.
///
/// With x, y, z being RayTest::axes(): the ray is a straight line over z, of the slopes
/// RayTest::shear(). It starts at the point p where it enters the slab of the mesh along z, or at
/// its origin if that is in there, so that all numbers are as small as the mesh however far the
/// origin is. "Depth" is the way along z from p on, never negative, of which all tests speak.
///
/// Bounds. RayTest rounds in double precision: a triangle that it hits has a point that is off the
/// line by no more than `error` (along x, and along y), which has a depth that gives the distance
/// of the hit up to `depth_error`; see meets(). What floats add:
/// * Boxes: a plane is at (plane - p) / slope. p is rounded by 2^-24 of itself: together with
///   `error` it is added to the origin for near planes and taken from the origin for far ones. The
///   difference, the inverse of the slope and the product are rounded by 2^-24 each, which is why
///   inverses are made smaller for near planes and larger for far ones by 2^-22. A slope of nearly
///   0 is replaced by 2^-40, the error of which counts as `error`; so there is never 0 times
///   infinity.
/// * Triangles: see TriangleFilter.
struct Beam
{
  enum class Reach
  {
    NOTHING,  ///< the ray cannot hit anything
    FLOATS,   ///< the tests hold
    ALL       ///< beyond floats: RayTest has to look at every triangle
  };

  Beam() = default;
  Beam(const Bvh& bvh, const RayTest& ray);

  /// Bound of the depth of hits that are as near as `distance` or nearer.
  float depth(double distance) const;

  Reach reach = Reach::NOTHING;
  std::array<unsigned, 3> near_plane{}, far_plane{};  // floats from BvhNode::lower on; x, y, z
  std::array<float, 3> near_origin{}, far_origin{}, near_inverse{}, far_inverse{};
  std::array<unsigned, 3> axes{0, 1, 2};
  std::array<float, 3> point{};       // p in coordinates of the mesh, along x, y, z
  std::array<float, 2> point_rest{};  // what is lost of it there, sheared
  std::array<float, 2> shear{};
  float corner_error = 0.0f;  // bound of the error of sheared corners, see TriangleFilter
  double depth_per_meter = 0.0, skipped_depth = 0.0, depth_error = 0.0;
};

/// Depths at which a beam enters the boxes of a node, and which it enters at all (bits) before
/// `limit`: slabs (T. Kay, J. Kajiya: Ray Tracing Complex Scenes, 1986), widened by the rounding
/// (T. Ize: Robust BVH Ray Traversal, 2013).
struct BoxHits
{
  Floats4 depths;
  unsigned hits;
};

inline BoxHits enterBoxes(const Beam& beam, const BvhNode& node, float limit)
{
  const float* const planes = node.lower[0];
  const auto plane = [&](unsigned offset, float origin, float inverse) {
    return (load4(planes + offset) - all4(origin)) * all4(inverse);
  };
  const auto near = [&](unsigned k) {
    return plane(beam.near_plane[k], beam.near_origin[k], beam.near_inverse[k]);
  };
  const auto far = [&](unsigned k) {
    return plane(beam.far_plane[k], beam.far_origin[k], beam.far_inverse[k]);
  };
  const Floats4 enter = maximum(maximum(near(0), near(1)), maximum(near(2), all4(0.0f)));
  const Floats4 leave = minimum(minimum(far(0), far(1)), minimum(far(2), all4(limit)));
  return {enter, bits(enter <= leave)};
}

/// Of the triangles of a leaf, those that RayTest may hit (bits): four at a time, in floats.
///
/// A sheared corner x = (corner_x - p_x) - shear_x * (corner_z - p_z) differs from that of RayTest
/// by at most e = Beam::corner_error. With m the largest of the |x| and |y| of a triangle, its edge
/// functions differ by at most 4 e m + 2 e^2 (as products of numbers that differ by e) + 2^-22 m^2
/// (three roundings), and RayTest hits only where none is positive or none is negative.
class TriangleFilter
{
 public:
  explicit TriangleFilter(const float* corners)
  {
    for (unsigned k = 0; k < 4; ++k) {
      rows_[k] = load4(corners + 9 * k);
      rows_[k + 4] = load4(corners + 9 * k + 4);
    }
    transpose(rows_[0], rows_[1], rows_[2], rows_[3]);
    transpose(rows_[4], rows_[5], rows_[6], rows_[7]);
    rows_[8] = Floats4{corners[8], corners[17], corners[26], corners[35]};
  }

  unsigned operator()(const Beam& beam) const
  {
    Floats4 x[3], y[3];
    for (unsigned k = 0; k < 3; ++k) {
      const Floats4* const corner = rows_ + 3 * k;
      const Floats4 z = corner[beam.axes[2]] - all4(beam.point[2]);
      x[k] = (corner[beam.axes[0]] - all4(beam.point[0])) - all4(beam.shear[0]) * z -
             all4(beam.point_rest[0]);
      y[k] = (corner[beam.axes[1]] - all4(beam.point[1])) - all4(beam.shear[1]) * z -
             all4(beam.point_rest[1]);
    }
    const Floats4 u = x[2] * y[1] - y[2] * x[1];
    const Floats4 v = x[0] * y[2] - y[0] * x[2];
    const Floats4 w = x[1] * y[0] - y[1] * x[0];
    const Floats4 m = maximum(
        maximum(maximum(absolute(x[0]), absolute(y[0])), maximum(absolute(x[1]), absolute(y[1]))),
        maximum(absolute(x[2]), absolute(y[2])));
    const Floats4 e = all4(beam.corner_error);
    // The last term is for products that are too small for floats.
    const Floats4 bound = (m * 0x1p-21f + e * 4.01f) * m + (e * e * 2.01f + 1e-36f);
    // Written so that a NaN is let pass.
    const Ints4 negative = (u < -bound) | (v < -bound) | (w < -bound);
    const Ints4 positive = (u > bound) | (v > bound) | (w > bound);
    return 0xFu ^ bits(negative & positive);
  }

 private:
  Floats4 rows_[9];
};

}  // namespace mesh_map
