#include <mesh_map/bvh/tree/back_end.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/require.h"
#include "base/run.h"
#include "base/vector3.h"
#include "bvh/rays/ray_packet.h"
#include "bvh/rays/ray_search.h"

namespace mesh_map {

namespace {

/// Smaller parts of an origin (meters) or a slope count as 0. Corners are floats, so no number that
/// meets() computes is then small enough to underflow: a sheared corner is 0 or above 1e-132, their
/// products and the residues of these are 0 or above 1e-300.
constexpr double SMALLEST_ORIGIN = 1e-60, SMALLEST_SLOPE = 1e-40;

double flush(double value, double smallest)
{
  return std::abs(value) < smallest ? 0.0 : value;
}

}  // namespace

RayTest::RayTest(const Ray& ray) : origin_(ray.origin), max_distance_(ray.max_distance)
{
  Vector3 d = ray.direction;
  const double sizes[3] = {std::abs(d[0]), std::abs(d[1]), std::abs(d[2])};
  const unsigned last =
      sizes[0] > sizes[1] ? (sizes[0] > sizes[2] ? 0 : 2) : (sizes[1] > sizes[2] ? 1 : 2);
  const double largest = sizes[last];
  if (!isFinite(origin_) || !isFinite(d) || largest == 0.0 || !(max_distance_ >= 0.0)) {
    return;
  }
  if (largest < 1e-100 || largest > 1e100) {  // whose squares would not be doubles
    const int exponent = std::ilogb(largest);
    for (double& component : d) {
      component = std::scalbn(component, -exponent);
    }
  }
  for (double& coordinate : origin_) {
    coordinate = flush(coordinate, SMALLEST_ORIGIN);
  }
  const double length = std::sqrt(dot(d, d));
  const Doubles2 first_two = Doubles2{d[0], d[1]} / length;
  direction_ = {first_two[0], first_two[1], d[2] / length};
  axes_ = {(last + 1) % 3, (last + 2) % 3, last};
  if (direction_[last] < 0.0) {
    std::swap(axes_[0], axes_[1]);
  }
  const Doubles2 slopes = Doubles2{d[axes_[0]], d[axes_[1]]} / d[last];
  shear_ = {flush(slopes[0], SMALLEST_SLOPE), flush(slopes[1], SMALLEST_SLOPE)};
  valid_ = true;
}

void checkMask(const Bvh& bvh, ArrayView<std::uint8_t> mask)
{
  require(mask.empty() || mask.size() == bvh.faceCount(),
          "a mask of " + std::to_string(mask.size()) + " entries does not fit a mesh of " +
              std::to_string(bvh.faceCount()) + " faces: one per face, or none");
}

RayHits::RayHits(std::size_t count) : faces(count), distances(count), barycentric(3 * count) {}

void RayHits::set(std::size_t index, const RayHit& hit)
{
  faces[index] = hit.face;
  distances[index] = hit.distance;
  std::copy(hit.barycentric.begin(), hit.barycentric.end(), barycentric.begin() + 3 * index);
}

RayHit castRay(const Bvh& bvh, const Ray& ray, const RayOptions& options)
{
  checkMask(bvh, options.mask);
  countQueries(BackEnd::NATIVE, Query::RAY, 1);
  RaySearch search(bvh, ray);
  searchAll<false>(bvh, options, search);
  return search.hit();
}

bool rayHitsAny(const Bvh& bvh, const Ray& ray, const RayOptions& options)
{
  checkMask(bvh, options.mask);
  countQueries(BackEnd::NATIVE, Query::RAY, 1);
  RaySearch search(bvh, ray);
  searchAll<true>(bvh, options, search);
  return search.best.face != NO_INDEX;
}

namespace {

/// Rays that a thread takes at once.
constexpr std::size_t CHUNK = 1024;

/// Rays that are prepared at once: as many as stay in the cache.
constexpr std::size_t GROUP = 32;

/// Searches all rays and calls `answer(index, search)` for each, from any thread.
template <class Answer>
void searchBatch(const Bvh& bvh, const RayBatch& rays, const RayOptions& options,
                 const BvhOptions& run_options, bool any, const Answer& answer)
{
  const SearchRays search_rays = fastestSearchRays();
  Run run(run_options);
  run.loop(rays.size(), CHUNK, 1.0, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      std::vector<RaySearch> group;
      group.reserve(GROUP);
      for (std::size_t first = begin; first < end; first += GROUP) {
        const std::size_t count = std::min(GROUP, end - first);
        group.clear();
        for (std::size_t i = 0; i < count; ++i) {
          group.emplace_back(bvh, rays[first + i]);
        }
        run.check();
        search_rays(bvh, options, any, group.data(), count);
        for (std::size_t i = 0; i < count; ++i) {
          answer(first + i, group[i]);
        }
      }
    };
  });
  run.finish();
  countQueries(BackEnd::NATIVE, Query::RAY, rays.size());
}

}  // namespace

Ray RayBatch::operator[](std::size_t index) const
{
  const double* const origin = origins.data() + (origins.size() == 3 ? 0 : 3 * index);
  const double* const direction = directions.data() + 3 * index;
  Ray ray = {{origin[0], origin[1], origin[2]}, {direction[0], direction[1], direction[2]}};
  if (!max_distances.empty()) {
    ray.max_distance = max_distances[max_distances.size() == 1 ? 0 : index];
  }
  return ray;
}

void RayBatch::check() const
{
  require(directions.size() % 3 == 0,
          std::to_string(directions.size()) + " numbers are no directions: 3 per ray are needed");
  const std::string rays = " do not fit " + std::to_string(size()) + " rays: ";
  require(origins.size() == 3 || origins.size() == directions.size(),
          std::to_string(origins.size()) + " numbers of origins" + rays +
              "3 per ray are needed, or 3 for all");
  require(max_distances.size() <= 1 || max_distances.size() == size(),
          std::to_string(max_distances.size()) + " maximum distances" + rays +
              "one per ray is needed, or one for all, or none");
}

RayHits castRays(const Bvh& bvh, const RayBatch& rays, const RayOptions& options,
                 const BvhOptions& run)
{
  rays.check();
  checkMask(bvh, options.mask);
  RayHits hits(rays.size());
  searchBatch(bvh, rays, options, run, false,
              [&hits](std::size_t i, const RaySearch& search) { hits.set(i, search.hit()); });
  return hits;
}

std::vector<std::uint8_t> raysHitAny(const Bvh& bvh, const RayBatch& rays,
                                     const RayOptions& options, const BvhOptions& run)
{
  rays.check();
  checkMask(bvh, options.mask);
  std::vector<std::uint8_t> hits(rays.size());
  searchBatch(bvh, rays, options, run, true, [&hits](std::size_t i, const RaySearch& search) {
    hits[i] = search.best.face != NO_INDEX ? 1 : 0;
  });
  return hits;
}

}  // namespace mesh_map
