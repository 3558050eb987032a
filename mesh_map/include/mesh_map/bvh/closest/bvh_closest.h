#pragma once

#include <mesh_map/bvh/tree/bvh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace mesh_map {

/// The point of a face that is nearest to a query point.
struct SurfaceHit
{
  std::uint32_t face = NO_INDEX;  ///< NO_INDEX: nothing within the maximum distance
  std::array<double, 3> barycentric = {0.0, 0.0, 0.0};
  std::array<double, 3> position = {0.0, 0.0, 0.0};
  double distance = std::numeric_limits<double>::infinity();
};

/// The nearest point of one triangle (its face index is not set). Corners and point have 3 numbers
/// each. A triangle without area is treated as the segments it consists of. Beyond 1e140 m all
/// points of a triangle are as near. A point that is not finite has no finite distance.
SurfaceHit closestPointOnTriangle(const float* a, const float* b, const float* c,
                                  const double* point);

struct VertexHit
{
  std::uint32_t vertex = NO_INDEX;  ///< NO_INDEX: nothing within the maximum distance
  double distance = std::numeric_limits<double>::infinity();
};

/// The nearest vertex among those whose entry in `eligible` is not 0 (an empty array: among all)
/// within the maximum distance. Of several as near, the one of lowest index. A point that is not
/// finite finds nothing; neither does a maximum distance that is negative or NaN.
VertexHit closestVertex(ArrayView<float> positions, ArrayView<std::uint8_t> eligible,
                        const double* point, double max_distance);

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
