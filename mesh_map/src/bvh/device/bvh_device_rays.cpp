#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/float_bits.h"
#include "base/run.h"
#include "bvh/device/device_frame.h"
#include "bvh/rays/ray_search.h"

namespace mesh_map {

namespace {

constexpr std::size_t CHUNK = 4096;

/// A slope of nearly 0 is replaced by this one for boxes, so that there is never 0 times infinity.
constexpr double SMALLEST_SLOPE = 0x1p-40;

void packCode(std::uint32_t code, float* packed)
{
  std::fill_n(packed, DEVICE_RAY_FLOATS, 0.0f);
  packed[3] = code == DEVICE_DOUBT ? 1.0f : -1.0f;  // the limit
  packed[7] = floatOf(code);
}

/// Packs a ray as kernels/bvh.cl reads it. It starts shortly before the slab of the mesh along z,
/// or at its origin if that is further, so that all numbers are as small as the mesh however far
/// the origin is. Its start is two floats per coordinate.
///
/// What RayTest rounds in double precision (ray_test.h) is off by no more than `error` along x
/// and y, and `depth_error` along z. What the kernel rounds:
///
/// * Boxes: near planes come nearer and far ones go farther by the error, the rounding of the
///   start, and 2^-21 for those of the difference, the inverse and the product.
/// * Triangles: a corner is sheared to x = dx - shear * dz, the differences to the start. These are
///   wrong by 2^-23 of themselves; shear, product and difference are rounded: in all 2^-24 (3 |dx|
///   + 5 |dz|). With |dx| <= m + |dz|, m being the largest sheared coordinate, that is less than e
///   = 2^-22 m + 2^-21 |dz|, to which the error is added. Edge functions are then wrong by less
///   than 4 e m + 2 e^2 (products of numbers that are wrong by e) + 2^-22 m^2 (three roundings).
/// * Depths: that of a hit is a mean of those of the corners, each of which is wrong by less than
///   the depth error + 2^-22 |dz|. Where edge functions are wrong by a bound b, and their sum is s,
///   weights are wrong by less than 6 b / s in all, hence depths by less than 3 b / s of their
///   range, and by some roundings of it.
///
/// A hit is sure if all edge functions are beyond the bound: it then limits the depth. All hits
/// that are not sure, and all that are not surely farther than a sure one, are candidates.
void packRay(const DeviceFrame& mesh, const RayTest& ray, float* packed)
{
  if (!ray.valid()) {
    return packCode(DEVICE_NONE, packed);
  }
  const auto [x, y, z] = ray.axes();
  const bool up = ray.direction()[z] > 0.0;
  const double sign = up ? 1.0 : -1.0;
  const double entry = up ? mesh.lower[z] : mesh.upper[z];
  const double exit = up ? mesh.upper[z] : mesh.lower[z];
  const double extent = mesh.upper[z] - mesh.lower[z];
  const double origin_z = ray.origin()[z] - mesh.center[z];
  const double away = std::abs(origin_z) + mesh.reach[z] + std::abs(mesh.center[z]);
  const double depth_error = 0x1p-29 * extent + DEVICE_ROUNDING * away;
  if (sign * (exit - origin_z) < -depth_error) {
    return packCode(DEVICE_NONE, packed);  // the mesh is behind it
  }
  const double before = 0x1p-16 * (extent + mesh.reach[z]) + 4.0 * depth_error;
  const double skipped = std::max(sign * (entry - origin_z) - before, 0.0);
  const double start_z = skipped > 0.0 ? entry - sign * before : origin_z;

  double start[3] = {0.0, 0.0, start_z}, inverse[2], error = 0.0;
  for (unsigned k = 0; k < 2; ++k) {
    const unsigned axis = k == 0 ? x : y;
    const double slope = ray.shear()[k];
    const double origin = ray.origin()[axis] - mesh.center[axis];
    start[k] = origin + sign * skipped * slope;
    const double own_error = DEVICE_ROUNDING * (std::abs(origin) + std::abs(slope) * away +
                                                mesh.reach[axis] + std::abs(mesh.center[axis])) +
                             2.0 * SMALLEST_SLOPE * extent + depth_error;
    if (std::abs(start[k]) - own_error > mesh.reach[axis] + 2.0 * (extent + before)) {
      return packCode(DEVICE_NONE, packed);  // it leaves the slab before it gets there
    }
    error = std::max(error, own_error);
    inverse[k] = 1.0 / (sign * std::copysign(std::max(std::abs(slope), SMALLEST_SLOPE), slope));
  }
  // So far away that all of the mesh would be in doubt. Negated, so that a NaN is.
  if (!(error <= 0x1p-10 * mesh.size)) {
    return packCode(DEVICE_DOUBT, packed);
  }

  // How far it may go for its maximum distance.
  const double ahead = ray.maxDistance() * std::abs(ray.direction()[z]);
  const double limit = ahead - skipped + depth_error + DEVICE_ROUNDING * ahead;
  if (limit < 0.0) {
    return packCode(DEVICE_NONE, packed);
  }
  const unsigned axes[3] = {x, y, z};
  double largest = 0.0, numbers = 0.0;
  for (unsigned k = 0; k < 3; ++k) {
    const double place = mesh.center[axes[k]] + start[k];
    packed[k] = static_cast<float>(place);
    packed[k + 4] = static_cast<float>(place - packed[k]);
    largest = std::max(largest, std::abs(start[k]));
    numbers = std::max(numbers, std::abs(place));
  }
  packed[3] = roundedUp(limit);
  packed[7] = floatOf(x | y << 2 | z << 4 | (up ? 0u : 64u));
  packed[8] = static_cast<float>(ray.shear()[0]);
  packed[9] = static_cast<float>(ray.shear()[1]);
  packed[10] = static_cast<float>(inverse[0]);
  packed[11] = static_cast<float>(inverse[1]);
  packed[12] = roundedUp(error + 0x1p-44 * numbers);        // of sheared corners
  packed[13] = roundedUp(depth_error + 0x1p-44 * numbers);  // of depths
  packed[14] = roundedUp(error + 0x1p-21 * (largest + error) + 0x1p-44 * numbers);  // of boxes
  packed[15] = 0.0f;
}

void checkRays(const Bvh& bvh, const RayBatch& rays, const RayOptions& options,
               ArrayView<std::uint32_t> answers)
{
  rays.check();
  checkMask(bvh, options.mask);
  checkAnswers(answers.size(), rays.size(), DEVICE_RAY_ANSWERS);
}

/// The first hit among the triangles that a device has named. False where it is in doubt, also if
/// it names what is no triangle.
bool decide(const Bvh& bvh, const Ray& ray, const RayOptions& options, const std::uint32_t* answers,
            RayHit& best)
{
  if (answers[0] == DEVICE_NONE) {
    return true;
  }
  const RayTest test(ray);
  for (std::size_t i = 0; i < DEVICE_RAY_ANSWERS && answers[i] != DEVICE_NONE; ++i) {
    if (answers[i] >= bvh.faceCount()) {
      return false;
    }
    const std::uint32_t face = bvh.faces()[answers[i]];
    RayHit hit;
    if ((options.mask.empty() || options.mask[face] != 0) && test.valid() &&
        meets(test, bvh.corners().data() + 9 * std::size_t{answers[i]}, options.back_faces,
              &hit.distance, &hit.barycentric) &&
        (hit.distance < best.distance || (hit.distance == best.distance && face < best.face))) {
      hit.face = face;
      best = hit;
    }
  }
  return true;
}

}  // namespace

std::vector<float> packRays(const Bvh& bvh, const RayBatch& rays, const BvhOptions& options)
{
  rays.check();
  const DeviceFrame mesh(bvh);
  std::vector<float> packed(DEVICE_RAY_FLOATS * (rays.size() + 1));
  std::copy(bvh.center().begin(), bvh.center().end(), packed.begin());
  float* const first = packed.data() + DEVICE_RAY_FLOATS;
  Run run(options);
  run.each(rays.size(), CHUNK, 1.0, [&, first](std::size_t i) {
    if (mesh.usable) {
      packRay(mesh, RayTest(rays[i]), first + DEVICE_RAY_FLOATS * i);
    } else {
      packCode(DEVICE_DOUBT, first + DEVICE_RAY_FLOATS * i);
    }
  });
  run.finish();
  return packed;
}

RayHits finishRays(const Bvh& bvh, const RayBatch& rays, const RayOptions& options,
                   ArrayView<std::uint32_t> answers, const BvhOptions& run_options)
{
  checkRays(bvh, rays, options, answers);
  RayHits hits(rays.size());
  Run run(run_options);
  run.each(rays.size(), CHUNK, 1.0, [&](std::size_t i) {
    RayHit hit;
    if (!decide(bvh, rays[i], options, answers.data() + DEVICE_RAY_ANSWERS * i, hit)) {
      hit = castRay(bvh, rays[i], options);
    }
    hits.set(i, hit);
  });
  run.finish();
  return hits;
}

std::vector<std::uint8_t> finishRaysAny(const Bvh& bvh, const RayBatch& rays,
                                        const RayOptions& options, ArrayView<std::uint32_t> answers,
                                        const BvhOptions& run_options)
{
  checkRays(bvh, rays, options, answers);
  std::vector<std::uint8_t> hits(rays.size());
  Run run(run_options);
  run.each(rays.size(), CHUNK, 1.0, [&](std::size_t i) {
    const std::uint32_t* const own = answers.data() + DEVICE_RAY_ANSWERS * i;
    RayHit hit;
    if (own[0] != DEVICE_NONE) {
      // Kernels stop at a hit that they are sure of, so a miss of all may not be one.
      hits[i] = (decide(bvh, rays[i], options, own, hit) && hit.face != NO_INDEX) ||
                rayHitsAny(bvh, rays[i], options);
    }
  });
  run.finish();
  return hits;
}

}  // namespace mesh_map
