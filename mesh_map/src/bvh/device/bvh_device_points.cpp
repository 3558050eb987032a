#include <algorithm>
#include <cmath>

#include "base/run.h"
#include "bvh/closest/closest_search.h"
#include "bvh/closest/triangle_point.h"
#include "bvh/device/device_frame.h"

namespace mesh_map {

namespace {

constexpr std::size_t CHUNK = 1024;

/// Fourth powers of coordinates are to be floats; and seen from further away than this many sizes
/// of the mesh, most of it is as near to a float.
constexpr double LARGEST = 1e8, MANY_SIZES = 1e3;

/// Packs a point as kernels/bvh.cl reads it: two floats per coordinate.
///
/// The kernel bounds the distance of a triangle from both sides. Below: whatever direction one
/// looks in, a triangle is no nearer than its nearest corner along that direction. Along the
/// normal, that is the distance of the plane; towards the nearest point of the nearest edge it is
/// that of this point, where the nearest point of all is on an edge. Above: the distance of a point
/// that is a mean of the corners with weights of 0 to 1. So rounding makes directions and weights
/// worse, but no bound wrong, but for that of the last steps: coordinates seen from the point
/// (2^-23), products and sums (2^-22), less than 2^-20 of the distance of the farthest corner in
/// all; and quotient and root (2^-18).
void packPoint(const DeviceFrame& mesh, const double* point, double max_distance, float* packed)
{
  double numbers = 0.0, away = 0.0, reach = 0.0;
  bool finite = true;
  for (std::size_t k = 0; k < 3; ++k) {
    finite = finite && std::isfinite(point[k]);
    numbers = std::max(numbers, std::abs(point[k]));
    away = std::max(away, std::abs(point[k] - mesh.center[k]));
    reach = std::max(reach, mesh.reach[k]);
  }
  std::fill_n(packed, DEVICE_POINT_FLOATS, 0.0f);
  if (!finite || !(max_distance >= 0.0)) {
    packed[3] = -1.0f;  // the limit
    return;
  }
  if (!(numbers <= LARGEST && reach <= LARGEST && away <= MANY_SIZES * mesh.size)) {
    packed[7] = -1.0f;  // the margin
    return;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    packed[k] = static_cast<float>(point[k]);
    packed[k + 4] = static_cast<float>(point[k] - packed[k]);
  }
  packed[3] = roundedUp(max_distance);
  packed[7] = roundedUp(0x1p-22 * away + 0x1p-44 * numbers);  // of boxes
}

/// The nearest of the triangles that a device has named. False where it is in doubt, also if it
/// names what is no triangle.
bool decide(const Bvh& bvh, const double* point, const ClosestOptions& options,
            const std::uint32_t* answers, SurfaceHit& best)
{
  double least = options.max_distance;
  const float* nearest = nullptr;
  for (std::size_t i = 0; i < DEVICE_CANDIDATES && answers[i] != DEVICE_NONE; ++i) {
    if (answers[i] >= bvh.faceCount()) {
      return false;
    }
    const std::uint32_t face = bvh.faces()[answers[i]];
    const float* const corners = bvh.corners().data() + 9 * std::size_t{answers[i]};
    const double distance = TrianglePoint(corners, corners + 3, corners + 6, point).distance();
    if ((distance < least || (distance == least && face < best.face)) &&
        (options.mask.empty() || options.mask[face] != 0)) {
      least = distance;
      best.face = face;
      nearest = corners;
    }
  }
  if (nearest != nullptr) {
    const std::uint32_t face = best.face;
    best = closestPointOnTriangle(nearest, nearest + 3, nearest + 6, point);
    best.face = face;
  }
  return true;
}

}  // namespace

bool deviceAnswers(const ClosestOptions& options)
{
  return options.normals.empty();
}

std::vector<float> packPoints(const Bvh& bvh, ArrayView<double> points,
                              const ClosestOptions& options, const BvhOptions& run_options)
{
  const std::size_t count = pointCount(points);
  checkMask(bvh, options.mask);
  const DeviceFrame mesh(bvh);
  std::vector<float> packed(DEVICE_POINT_FLOATS * (count + 1));
  std::copy(bvh.center().begin(), bvh.center().end(), packed.begin());
  float* const first = packed.data() + DEVICE_POINT_FLOATS;
  Run run(run_options);
  run.each(count, CHUNK, 1.0, [&, first](std::size_t i) {
    packPoint(mesh, points.data() + 3 * i, options.max_distance, first + DEVICE_POINT_FLOATS * i);
  });
  run.finish();
  return packed;
}

SurfaceHits finishPoints(const Bvh& bvh, ArrayView<double> points, const ClosestOptions& options,
                         ArrayView<std::uint32_t> answers, const BvhOptions& run_options)
{
  if (!deviceAnswers(options)) {
    return closestPoints(bvh, points, options, run_options);
  }
  const std::size_t count = pointCount(points);
  checkMask(bvh, options.mask);
  checkAnswers(answers.size(), count, DEVICE_CANDIDATES);
  SurfaceHits hits(count);
  Run run(run_options);
  run.each(count, CHUNK, 1.0, [&](std::size_t i) {
    const double* const point = points.data() + 3 * i;
    SurfaceHit hit;
    if (!decide(bvh, point, options, answers.data() + DEVICE_CANDIDATES * i, hit)) {
      run.check();
      hit = closestPoint(bvh, point, options);
    }
    hits.set(i, hit);
  });
  run.finish();
  return hits;
}

}  // namespace mesh_map
