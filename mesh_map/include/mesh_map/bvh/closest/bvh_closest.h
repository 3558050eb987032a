#pragma once

#include <mesh_map/bvh/closest/closest_point.h>
#include <mesh_map/bvh/tree/bvh.h>

#include <limits>
#include <vector>

namespace mesh_map {

/// Which faces count for a closest point.
struct ClosestOptions
{
  double max_distance = std::numeric_limits<double>::infinity();

  /// Only faces whose normal is within max_angle (radians, 0 to pi) of this direction (any length
  /// but 0); a maximum angle of pi or more lets all faces count, those without area too, which have
  /// no normal and else do not. Per point, or one for all, or none (empty).
  ArrayView<double> normals;
  double max_angle = 3.141592653589793;

  ArrayView<std::uint8_t> mask;  ///< per face: 0 = does not count; empty: all count
};

/// Answers for many points: one entry (three of the last two) per point, as in SurfaceHit.
struct SurfaceHits
{
  SurfaceHits() = default;
  explicit SurfaceHits(std::size_t count);
  void set(std::size_t index, const SurfaceHit& hit);

  std::vector<std::uint32_t> faces;
  std::vector<double> distances;
  std::vector<double> positions;
  std::vector<double> barycentric;
};

/// The nearest point of the mesh. Of faces as near, the one of lowest index. A point, normal or
/// distance that is not finite (a maximum distance of +inf excepted), or a normal of 0, finds
/// nothing, nor does a distance or angle that is negative or NaN. `options.normals` has 3 numbers
/// or none. Throws std::invalid_argument for arrays of other sizes.
///
/// It takes microseconds, but looks at much of the mesh where much is as near (as from the middle
/// of a ball), or where few faces count.
SurfaceHit closestPoint(const Bvh& bvh, const double* point, const ClosestOptions& options = {});

/// closestPoint() for each point, 3 doubles each. Points that follow each other had better be near
/// each other. Throws Canceled, std::bad_alloc, or std::invalid_argument for arrays that do not
/// fit each other.
SurfaceHits closestPoints(const Bvh& bvh, ArrayView<double> points,
                          const ClosestOptions& options = {}, const BvhOptions& run = {});

}  // namespace mesh_map
