#include <mesh_map/bvh/device/bvh_device.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <string>

#include "base/float_bits.h"
#include "base/require.h"
#include "base/run.h"
#include "bvh/closest/triangle_point.h"
#include "bvh/rays/ray_search.h"
#include "bvh/selection/bvh_selection_filters.h"
#include "bvh/selection/bvh_selection_sort.h"

namespace mesh_map {

static_assert(BVH_STACK <= 128 && BVH_WIDTH == 4 && BVH_LEAF_SIZE == 4, "kernels/bvh.cl says so");
static_assert(Bvh::TAIL >= 9 * (BVH_LEAF_SIZE - 1), "kernels read whole leaves");

const char* const BVH_KERNEL_OPTIONS = "-cl-std=CL1.2";

namespace {

/// Meshes, rays and points with larger local coordinates are beyond the kernels: everything is in
/// doubt. Squares of these are floats.
constexpr double DEVICE_LARGEST = 1e17;

/// Bound of the error of some operations in double precision, relative to the size of the numbers.
constexpr double DEVICE_ROUNDING = 0x1p-48;

/// A float that is not less than a bound that is not negative; large ones are cut.
float roundedUp(double bound)
{
  return static_cast<float>(std::fmin(bound, 1e30) * (1.0 + 0x1p-22) + 1e-36);
}

/// The box of the mesh in local coordinates in double precision.
struct DeviceFrame
{
  explicit DeviceFrame(const Bvh& bvh)
  {
    for (std::size_t k = 0; k < 3; ++k) {
      center[k] = bvh.center()[k];
      lower[k] = bvh.lower()[k];
      upper[k] = bvh.upper()[k];
      reach[k] = std::max(std::abs(lower[k]), std::abs(upper[k]));
      size = std::max(size, upper[k] - lower[k]);
      usable = usable && reach[k] <= DEVICE_LARGEST;
    }
  }

  std::array<double, 3> center, lower, upper, reach;  ///< reach: largest coordinates
  double size = 0.0;                                  ///< largest extent
  bool usable = true;                                 ///< by kernels
};

/// Throws std::invalid_argument unless there are `per_item` answers for each of `count` items.
void checkAnswers(std::size_t answers, std::size_t count, std::size_t per_item)
{
  require(answers == count * per_item,
          std::to_string(answers) + " answers of a device do not fit " + std::to_string(count) +
              " queries: " + std::to_string(per_item) + " for each");
}

}  // namespace

std::vector<std::uint8_t> deviceMask(const Bvh& bvh, ArrayView<std::uint8_t> mask)
{
  checkMask(bvh, mask);
  std::vector<std::uint8_t> result(mask.size());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    result[i] = mask[bvh.faces()[i]];
  }
  return result;
}

namespace {

/// Rays that a thread takes at once.
constexpr std::size_t RAY_CHUNK = 4096;

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
  run.each(rays.size(), RAY_CHUNK, 1.0, [&, first](std::size_t i) {
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
  run.each(rays.size(), RAY_CHUNK, 1.0, [&](std::size_t i) {
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
  run.each(rays.size(), RAY_CHUNK, 1.0, [&](std::size_t i) {
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

namespace {

/// Points that a thread takes at once.
constexpr std::size_t POINT_CHUNK = 1024;

/// Larger numbers leave everything unsure: fourth powers are to be floats.
constexpr double LARGEST = 1e8;

/// Seen from further away than this many sizes of the mesh, most of it is as near to a float.
constexpr double MANY_SIZES = 1e3;

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
  run.each(count, POINT_CHUNK, 1.0, [&, first](std::size_t i) {
    packPoint(mesh, points.data() + 3 * i, options.max_distance, first + DEVICE_POINT_FLOATS * i);
  });
  run.finish();
  return packed;
}

SurfaceHits finishPoints(const Bvh& bvh, ArrayView<double> points, const ClosestOptions& options,
                         ArrayView<std::uint32_t> answers, const BvhOptions& run_options)
{
  require(options.normals.empty(), "devices do not know the normals of faces");
  const std::size_t count = pointCount(points);
  checkMask(bvh, options.mask);
  checkAnswers(answers.size(), count, DEVICE_CANDIDATES);
  SurfaceHits hits(count);
  Run run(run_options);
  run.each(count, POINT_CHUNK, 1.0, [&](std::size_t i) {
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

namespace {

/// Work items that keep a device busy: trees are split until there are so many.
constexpr std::size_t ENOUGH_ROOTS = 1024;

struct Subtree
{
  std::uint32_t child, first, count;
};

/// The children of these subtrees that the region may touch; leaves stay.
template <class Filter>
std::vector<Subtree> childrenOf(const Bvh& bvh, const Filter& filter,
                                const std::vector<Subtree>& trees)
{
  std::vector<Subtree> children;
  ChildSides sides;
  for (const Subtree& tree : trees) {
    if (isLeaf(tree.child)) {
      children.push_back(tree);
      continue;
    }
    const BvhNode& node = bvh.nodes()[tree.child];
    filter.children(node, filter.cutting(), sides);
    std::uint32_t first = tree.first;
    for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
      if (node.child[k] != BVH_NO_CHILD && sides.side[k] != Side::OUTSIDE) {
        children.push_back({node.child[k], first, node.count[k]});
      }
      first += node.count[k];
    }
  }
  return children;
}

template <class Filter>
std::vector<Subtree> split(const Bvh& bvh, const Filter& filter)
{
  std::vector<Subtree> trees = {{0, 0, static_cast<std::uint32_t>(bvh.faceCount())}};
  const auto is_leaf = [](const Subtree& tree) { return isLeaf(tree.child); };
  while (trees.size() < ENOUGH_ROOTS && !std::all_of(trees.begin(), trees.end(), is_leaf)) {
    trees = childrenOf(bvh, filter, trees);
  }
  return trees;
}

/// Bound of what a region rounds in double precision, for numbers of this size.
float roundingOf(const DeviceFrame& mesh, double numbers)
{
  return mesh.usable ? roundedUp(0x1p-44 * numbers) : std::numeric_limits<float>::infinity();
}

}  // namespace

std::vector<std::uint32_t> selectionRoots(const Bvh& bvh, const Region& region)
{
  std::vector<Subtree> trees;
  const auto* const sphere = dynamic_cast<const SphereRegion*>(&region);
  const auto* const convex = dynamic_cast<const ConvexRegion*>(&region);
  require(sphere != nullptr || convex != nullptr, "devices select by spheres and planes only");
  if (region.valid()) {
    trees = sphere != nullptr ? split(bvh, SphereFilter(bvh, *sphere))
                              : split(bvh, ConvexFilter(bvh, *convex));
  }
  std::vector<std::uint32_t> roots;
  roots.reserve(2 * trees.size());
  for (const Subtree& tree : trees) {
    roots.push_back(tree.child);
    roots.push_back(isLeaf(tree.child) ? tree.count : tree.first);
  }
  return roots;
}

std::vector<float> packSphere(const Bvh& bvh, const SphereRegion& sphere)
{
  const DeviceFrame mesh(bvh);
  std::vector<float> packed(16, 0.0f);
  double numbers = sphere.radius(), away = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double place = sphere.center()[k];
    numbers = std::max({numbers, std::abs(place), std::abs(mesh.center[k]), mesh.reach[k]});
    away = std::max(away, std::abs(place - mesh.center[k]));
  }
  if (!sphere.valid()) {
    packed[3] = packed[7] = -1.0f;
    return packed;
  }
  if (!(numbers <= LARGEST)) {
    packed[12] = std::numeric_limits<float>::infinity();
    return packed;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const double place = sphere.center()[k];
    packed[k] = static_cast<float>(place);
    packed[k + 4] = static_cast<float>(place - packed[k]);
    packed[k + 8] = static_cast<float>(place - mesh.center[k]);
  }
  packed[3] = static_cast<float>(sphere.radius() * (1.0 - 0x1p-22));
  packed[7] = roundedUp(sphere.radius());
  packed[11] = roundedUp(0x1p-22 * away + 0x1p-44 * numbers);
  packed[12] = roundingOf(mesh, numbers) + 1e-17f;
  return packed;
}

std::vector<float> packPlanes(const Bvh& bvh, const ConvexRegion& region)
{
  const DeviceFrame mesh(bvh);
  std::vector<float> packed(4 + 8 * region.planes().size(), 0.0f);
  std::copy(bvh.center().begin(), bvh.center().end(), packed.begin());
  float* at = packed.data() + 4;
  for (const Plane& plane : region.planes()) {
    double numbers = std::abs(plane[3]), height = plane[3];
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = static_cast<float>(plane[k]);
      numbers += std::abs(plane[k]) * (std::abs(mesh.center[k]) + mesh.reach[k]);
      height += plane[k] * mesh.center[k];
    }
    at[3] = static_cast<float>(std::max(-1e30, std::min(1e30, height)));
    at[4] = roundingOf(mesh, numbers);
    at += 8;
  }
  return packed;
}

std::vector<std::uint32_t> finishSelection(const Bvh& bvh, const Region& region, SelectionMode mode,
                                           ArrayView<std::uint8_t> mask,
                                           ArrayView<std::uint8_t> verdicts,
                                           const BvhOptions& run_options)
{
  checkMask(bvh, mask);
  require(verdicts.size() == bvh.faceCount(),
          std::to_string(verdicts.size()) + " verdicts of a device do not fit " +
              std::to_string(bvh.faceCount()) + " faces: one for each");
  const auto isSelected = [&](std::size_t i) {
    std::uint8_t verdict = verdicts[i];
    if (verdict > DEVICE_INSIDE) {
      const Side side = region.triangle(bvh.corners().data() + 9 * i);
      verdict = side == Side::OUTSIDE    ? DEVICE_OUTSIDE
                : side == Side::TOUCHING ? DEVICE_TOUCHING
                                         : DEVICE_INSIDE;
    }
    return verdict == DEVICE_INSIDE ||
           (verdict == DEVICE_TOUCHING && mode == SelectionMode::TOUCHING);
  };
  std::mutex mutex;
  std::vector<TriangleRange> all;
  Run run(run_options);
  constexpr std::size_t chunk = 16384;
  run.loop(verdicts.size(), chunk, 1.0, [&]() -> RangeBody {
    return [&, ranges = std::vector<TriangleRange>()](std::size_t begin, std::size_t end) mutable {
      ranges.clear();
      for (std::size_t i = begin; i < end; ++i) {
        if (verdicts[i] == DEVICE_OUTSIDE || !isSelected(i)) {
          continue;
        }
        const auto at = static_cast<std::uint32_t>(i);
        if (!ranges.empty() && ranges.back().end == at) {
          ++ranges.back().end;
        } else {
          ranges.push_back({at, at + 1});
        }
      }
      const std::lock_guard<std::mutex> lock(mutex);
      all.insert(all.end(), ranges.begin(), ranges.end());
    };
  });
  run.finish();
  return facesOf(bvh.faces(), all, mask);
}

}  // namespace mesh_map
