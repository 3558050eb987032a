#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "reconstruction/cell_walk.h"
#include "reconstruction/field_input.h"
#include "reconstruction/surface_normals.h"

namespace mesh_map {

inline float dot(const Vector3f& a, const Vector3f& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// a + t b
inline Vector3f along(const Vector3f& a, float t, const Vector3f& b)
{
  return {a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]};
}

/// A measured point, with the plane through it by which it changes voxels; lengths in voxels.
struct MeasuredRay
{
  Vector3f point, normal;  ///< the normal towards the sensor
  float weight = 0;        ///< 0: of no use
};

/// Ends of straight lines, on which voxels are changed; in voxels.
struct RayParts
{
  Vector3f front, back;      ///< along the ray
  Vector3f outside, inside;  ///< across the surface, where `is_grazing`
  bool is_grazing = false;
};

/// Rays of some of the measured points, one for each.
class MeasuredRays
{
 public:
  /// Of the points from `begin` to below `end`. The points have to outlive it.
  MeasuredRays(const FieldOptions& options, const MeasuredPoints& measured, std::size_t begin,
               std::size_t end);

  /// Makes some of the rays, with normals against their way, and says what became of their points.
  IntegrationCounts make(std::size_t begin, std::size_t end);

  /// Gives a ray its normal, by that of the surface around, and the rest of its weight.
  RayParts aim(std::size_t ray, const PointNormal& around);
  /// Of a ray that is aimed.
  RayParts parts(std::size_t ray) const;

  std::size_t size() const { return rays_.size(); }
  const MeasuredRay& operator[](std::size_t ray) const { return rays_[ray]; }
  std::size_t point(std::size_t ray) const { return begin_ + ray; }
  Vector3f sensor(std::size_t ray) const;  ///< in voxels

 private:
  const FieldOptions& options_;
  const MeasuredPoints& measured_;
  std::size_t begin_;
  float per_meter_, truncation_;
  std::vector<MeasuredRay> rays_;
};

}  // namespace mesh_map
