#include <mesh_map/bvh/tree/back_end.h>

#include <algorithm>
#include <string>

#include "base/require.h"
#include "base/run.h"
#include "bvh/rays/ray_packet.h"
#include "bvh/rays/ray_search.h"

namespace mesh_map {

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
