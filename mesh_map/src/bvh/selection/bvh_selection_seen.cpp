#include <mesh_map/base/parallel.h>
#include <mesh_map/bvh/closest/bvh_closest.h>
#include <mesh_map/bvh/selection/bvh_selection.h>

#include <algorithm>
#include <cmath>

#include "base/vector3.h"

namespace mesh_map {

namespace {

/// Faces whose rays are cast together: as many as a device likes, in memory that is there.
constexpr std::size_t BATCH = std::size_t{1} << 18;

constexpr std::size_t CHUNK = 2048;

/// How near a point of a face that a ray meets counts as the same point.
double tolerance(const Vector3& sample, double distance)
{
  constexpr double neighboring_floats = 1.0 / 8388608.0;
  const double largest = std::max({std::abs(sample[0]), std::abs(sample[1]), std::abs(sample[2])});
  return 1e-9 * distance + neighboring_floats * largest;
}

/// The centroid of one of the three triangles that the middles of edges cut off, or of the whole.
Vector3 samplePoint(const float* corners, std::size_t corner)
{
  Vector3 point;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double sum = double{corners[axis]} + corners[3 + axis] + corners[6 + axis];
    point[axis] = corner < 3 ? (sum + 3.0 * corners[3 * corner + axis]) / 6.0 : sum / 3.0;
  }
  return point;
}

/// What a sample needs to be seen.
enum class Sight : std::uint8_t
{
  NO_SAMPLE,
  SURE,
  FREE_RAY
};

/// Samples of some faces, `per_face` places for each, and the rays to them.
class SampleRays
{
 public:
  SampleRays(const Vector3& eye, std::size_t faces, std::size_t per_face)
      : eye_(eye),
        sights_(faces * per_face, Sight::NO_SAMPLE),
        directions_(3 * faces * per_face, 0.0),
        limits_(faces * per_face, -1.0)  // no ray
  {
  }

  void set(std::size_t index, const Vector3& sample)
  {
    const Vector3 way = sample - eye_;
    const double distance = norm(way);
    const double limit = distance - tolerance(sample, distance);
    sights_[index] = limit > 0.0 ? Sight::FREE_RAY : Sight::SURE;
    std::copy(way.begin(), way.end(), directions_.begin() + 3 * index);
    limits_[index] = limit > 0.0 ? limit : -1.0;
  }

  RayHits cast(const RayCast& cast) const { return cast({{eye_.data(), 3}, directions_, limits_}); }

  Sight sight(std::size_t index) const { return sights_[index]; }

  /// Whether the face that hides a sample touches it.
  bool touches(std::size_t index, const float* corners) const
  {
    const Vector3 sample = eye_ + Vector3{directions_[3 * index], directions_[3 * index + 1],
                                          directions_[3 * index + 2]};
    const double distance = limits_[index];
    return closestPointOnTriangle(corners, corners + 3, corners + 6, sample.data()).distance <=
           tolerance(sample, distance);
  }

 private:
  Vector3 eye_;
  std::vector<Sight> sights_;
  std::vector<double> directions_, limits_;
};

class SeenFaces
{
 public:
  SeenFaces(const Bvh& bvh, const Region& region, const Vector3& eye, const RayCast& cast)
      : bvh_(bvh), region_(region), eye_(eye), cast_(cast), places_(bvh.faceCount())
  {
    parallelEach(places_.size(), 1 << 16, 0, [this](std::size_t i) {
      places_[bvh_.faces()[i]] = static_cast<std::uint32_t>(i);
    });
  }

  /// Adds the seen ones of a batch, in their order.
  void look(ArrayView<std::uint32_t> faces, std::vector<std::uint32_t>& found) const
  {
    SampleRays centers(eye_, faces.size(), 1);
    parallelEach(faces.size(), CHUNK, 0, [&](std::size_t i) {
      const Vector3 center = samplePoint(corners(faces[i]), 3);
      if (region_.contains(center)) {
        centers.set(i, center);
      }
    });
    std::vector<std::uint8_t> seen = cast(faces, centers, 1);

    std::vector<std::uint32_t> others;  // places in faces and seen
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (seen[i] == 0) {
        others.push_back(static_cast<std::uint32_t>(i));
      }
    }
    const std::vector<std::uint8_t> seen_now = lookAtCorners(faces, others, centers);
    for (std::size_t i = 0; i < others.size(); ++i) {
      seen[others[i]] = seen_now[i];
    }
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (seen[i] != 0) {
        found.push_back(faces[i]);
      }
    }
  }

 private:
  const float* corners(std::uint32_t face) const
  {
    return bvh_.corners().data() + 9 * std::size_t{places_[face]};
  }

  /// Of each face, whether one of its samples is seen.
  std::vector<std::uint8_t> cast(ArrayView<std::uint32_t> faces, const SampleRays& rays,
                                 std::size_t per_face) const
  {
    std::vector<std::uint8_t> seen(faces.size(), 0);
    if (faces.empty()) {
      return seen;
    }
    const RayHits hits = rays.cast(cast_);
    parallelEach(faces.size(), CHUNK, 0, [&](std::size_t i) {
      for (std::size_t k = per_face * i; k < per_face * (i + 1); ++k) {
        const std::uint32_t hit = hits.faces[k];
        if (rays.sight(k) == Sight::SURE ||
            (rays.sight(k) == Sight::FREE_RAY &&
             (hit == NO_INDEX || hit == faces[i] || rays.touches(k, corners(hit))))) {
          seen[i] = 1;
        }
      }
    });
    return seen;
  }

  /// The samples other than the centroids, or the witnesses where there are no samples.
  std::vector<std::uint8_t> lookAtCorners(ArrayView<std::uint32_t> faces,
                                          const std::vector<std::uint32_t>& others,
                                          const SampleRays& centers) const
  {
    std::vector<std::uint32_t> looked_at(others.size());
    SampleRays rays(eye_, others.size(), 3);
    parallelEach(others.size(), CHUNK, 0, [&](std::size_t i) {
      looked_at[i] = faces[others[i]];
      const float* const triangle = corners(looked_at[i]);
      bool any = centers.sight(others[i]) != Sight::NO_SAMPLE;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector3 sample = samplePoint(triangle, k);
        if (region_.contains(sample)) {
          rays.set(3 * i + k, sample);
          any = true;
        }
      }
      if (!any) {
        rays.set(3 * i, region_.witness(triangle));
      }
    });
    return cast(looked_at, rays, 3);
  }

  const Bvh& bvh_;
  const Region& region_;
  const Vector3 eye_;
  const RayCast& cast_;
  std::vector<std::uint32_t> places_;  // of faces among the triangles
};

}  // namespace

std::vector<std::uint32_t> seenFaces(const Bvh& bvh, const Region& region,
                                     ArrayView<std::uint32_t> faces,
                                     const std::array<double, 3>& eye, const RayCast& cast)
{
  std::vector<std::uint32_t> found;
  if (faces.empty() || !isFinite(eye)) {
    return found;
  }
  const SeenFaces search(bvh, region, eye, cast);
  for (std::size_t begin = 0; begin < faces.size(); begin += BATCH) {
    search.look({faces.data() + begin, std::min(BATCH, faces.size() - begin)}, found);
  }
  return found;
}

}  // namespace mesh_map
