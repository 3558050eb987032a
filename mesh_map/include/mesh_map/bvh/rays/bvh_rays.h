#pragma once

#include <mesh_map/bvh/tree/bvh.h>

#include <array>
#include <limits>
#include <vector>

namespace mesh_map {

/// A ray in the coordinates of the mesh.
struct Ray
{
  std::array<double, 3> origin{};
  std::array<double, 3> direction{};  ///< of any length but 0
  double max_distance = std::numeric_limits<double>::infinity();
};

/// Where a ray meets the mesh.
struct RayHit
{
  std::uint32_t face = NO_INDEX;                              ///< NO_INDEX: nowhere
  double distance = std::numeric_limits<double>::infinity();  ///< meters from the origin, >= 0
  std::array<double, 3> barycentric{};                        ///< weights of the corners
};

struct RayOptions
{
  bool back_faces = true;        ///< false: faces seen from behind (clockwise) are passed
  ArrayView<std::uint8_t> mask;  ///< per face: 0 = passed; empty: all count
};

/// Many rays as flat arrays of doubles.
struct RayBatch
{
  ArrayView<double> origins;        ///< 3 per ray, or 3 for all
  ArrayView<double> directions;     ///< 3 per ray
  ArrayView<double> max_distances;  ///< one per ray, or one for all, or none

  std::size_t size() const { return directions.size() / 3; }

  /// A ray below size(), of arrays that have the sizes above.
  Ray operator[](std::size_t index) const;

  /// Throws std::invalid_argument where the arrays do not have the sizes above.
  void check() const;
};

/// One entry (three of barycentric) per ray, as in RayHit.
struct RayHits
{
  RayHits() = default;
  explicit RayHits(std::size_t count);
  void set(std::size_t index, const RayHit& hit);

  std::vector<std::uint32_t> faces;
  std::vector<double> distances;
  std::vector<double> barycentric;
};

/// A ray as the exact test has it: whether and where it meets one triangle, in double precision.
///
/// Watertight (S. Woop, C. Benthin, I. Wald: Watertight Ray/Triangle Intersection, 2013): corners
/// are sheared so that the ray is an axis, edges count as hit, and an edge that two triangles share
/// is seen alike from both, so no ray slips through. A triangle without area, or whose plane
/// contains the ray, is not hit, unless rounding gives it an area (of some 1e-16 of its size).
///
/// A ray that is not finite, has the direction 0, or a maximum distance that is negative or NaN,
/// hits nothing.
class RayTest
{
 public:
  /// Parts of the origin below 1e-60 m, and slopes below 1e-40, count as 0.
  explicit RayTest(const Ray& ray);

  bool valid() const { return valid_; }

  const std::array<double, 3>& origin() const { return origin_; }
  const std::array<double, 3>& direction() const { return direction_; }  ///< of length 1
  double maxDistance() const { return max_distance_; }

  /// The axes, the one that the ray runs along the most being the last, in such an order that
  /// triangles that are counter-clockwise seen from the origin are so in the first two.
  const std::array<unsigned, 3>& axes() const { return axes_; }

  /// What the ray goes along the first two of axes() per meter along the last: from -1 to 1.
  const std::array<double, 2>& shear() const { return shear_; }

 private:
  bool valid_ = false;
  std::array<double, 3> origin_{}, direction_{};
  double max_distance_ = -1.0;
  std::array<unsigned, 3> axes_{0, 1, 2};
  std::array<double, 2> shear_{};
};

/// The nearest hit: of faces as near (equal in double precision), the one of lowest index. Throws
/// std::invalid_argument for a mask of another size than one per face, as all below do.
RayHit castRay(const Bvh& bvh, const Ray& ray, const RayOptions& options = {});

/// Whether there is any hit.
bool rayHitsAny(const Bvh& bvh, const Ray& ray, const RayOptions& options = {});

/// castRay() for each ray. Throws Canceled, std::bad_alloc, or std::invalid_argument for arrays
/// that do not fit each other.
RayHits castRays(const Bvh& bvh, const RayBatch& rays, const RayOptions& options = {},
                 const BvhOptions& run = {});

/// rayHitsAny() for each ray, 1 or 0.
std::vector<std::uint8_t> raysHitAny(const Bvh& bvh, const RayBatch& rays,
                                     const RayOptions& options = {}, const BvhOptions& run = {});

}  // namespace mesh_map
