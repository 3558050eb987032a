#include <mesh_map/bvh/closest/bvh_closest.h>

#include <mesh_map/bvh/tree/back_end.h>

#include <algorithm>
#include <string>

#include "base/run.h"
#include "bvh/closest/closest_search.h"
#include "bvh/closest/normal_filter.h"

namespace mesh_map {

namespace {

void require(bool condition, const std::string& what, std::size_t numbers, const std::string& need)
{
  if (!condition) {
    throw std::invalid_argument(what + " of " + std::to_string(numbers) + " numbers: " + need);
  }
}

void check(const Bvh& bvh, std::size_t points, const ClosestOptions& options)
{
  const std::size_t normals = options.normals.size(), mask = options.mask.size();
  require(normals == 0 || normals == 3 || normals == 3 * points, "normals", normals,
          "3 for each of " + std::to_string(points) + " points, 3 for all, or none");
  require(mask == 0 || mask == bvh.faceCount(), "a mask", mask,
          "one for each of " + std::to_string(bvh.faceCount()) + " faces, or none");
}

const double* normalOf(const ClosestOptions& options, std::size_t point)
{
  const std::size_t numbers = options.normals.size();
  return numbers == 0 ? nullptr : options.normals.data() + (numbers == 3 ? 0 : 3 * point);
}

}  // namespace

bool normalWithin(const float* corners, const std::array<double, 3>& direction, double max_angle)
{
  const NormalFilter filter(direction, max_angle);
  return filter.valid() && filter(corners);
}

SurfaceHit closestPoint(const Bvh& bvh, const double* point, const ClosestOptions& options)
{
  check(bvh, 1, options);
  countQueries(BackEnd::NATIVE, Query::CLOSEST_POINT, 1);
  return ClosestSearch(bvh, options)(point, normalOf(options, 0));
}

SurfaceHits closestPoints(const Bvh& bvh, ArrayView<double> points, const ClosestOptions& options,
                          const BvhOptions& run_options)
{
  require(points.size() % 3 == 0, "points", points.size(), "3 for each point");
  const std::size_t count = points.size() / 3;
  check(bvh, count, options);
  SurfaceHits hits;
  hits.faces.resize(count);
  hits.distances.resize(count);
  hits.positions.resize(3 * count);
  hits.barycentric.resize(3 * count);

  Run run(run_options);
  constexpr std::size_t chunk = 256;
  run.loop(count, chunk, 1.0, [&]() -> RangeBody {
    return [&, search = ClosestSearch(bvh, options)](std::size_t begin, std::size_t end) mutable {
      for (std::size_t i = begin; i < end; ++i) {
        run.check();  // one point can take long: far away, or among faces that do not count
        const SurfaceHit hit = search(points.data() + 3 * i, normalOf(options, i));
        hits.faces[i] = hit.face;
        hits.distances[i] = hit.distance;
        std::copy(hit.position.begin(), hit.position.end(), hits.positions.begin() + 3 * i);
        std::copy(hit.barycentric.begin(), hit.barycentric.end(), hits.barycentric.begin() + 3 * i);
      }
    };
  });
  run.finish();
  countQueries(BackEnd::NATIVE, Query::CLOSEST_POINT, count);
  return hits;
}

}  // namespace mesh_map
