#include <mesh_map/bvh/closest/bvh_closest.h>

#include <mesh_map/bvh/tree/back_end.h>

#include <algorithm>
#include <string>

#include "base/require.h"
#include "base/run.h"
#include "bvh/closest/closest_search.h"
#include "bvh/closest/normal_filter.h"

namespace mesh_map {

namespace {

void check(const Bvh& bvh, std::size_t points, const ClosestOptions& options)
{
  const std::size_t normals = options.normals.size(), mask = options.mask.size();
  require(normals == 0 || normals == 3 || normals == 3 * points,
          "normals of " + std::to_string(normals) + " numbers: 3 for each of " +
              std::to_string(points) + " points, 3 for all, or none");
  require(mask == 0 || mask == bvh.faceCount(),
          "a mask of " + std::to_string(mask) + " numbers: one for each of " +
              std::to_string(bvh.faceCount()) + " faces, or none");
}

const double* normalOf(const ClosestOptions& options, std::size_t point)
{
  const std::size_t numbers = options.normals.size();
  return numbers == 0 ? nullptr : options.normals.data() + (numbers == 3 ? 0 : 3 * point);
}

}  // namespace

SurfaceHits::SurfaceHits(std::size_t count)
    : faces(count), distances(count), positions(3 * count), barycentric(3 * count)
{
}

void SurfaceHits::set(std::size_t index, const SurfaceHit& hit)
{
  faces[index] = hit.face;
  distances[index] = hit.distance;
  std::copy(hit.position.begin(), hit.position.end(), positions.begin() + 3 * index);
  std::copy(hit.barycentric.begin(), hit.barycentric.end(), barycentric.begin() + 3 * index);
}

std::size_t pointCount(ArrayView<double> points)
{
  require(points.size() % 3 == 0,
          "points of " + std::to_string(points.size()) + " numbers: 3 for each point");
  return points.size() / 3;
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
  const std::size_t count = pointCount(points);
  check(bvh, count, options);
  SurfaceHits hits(count);
  Run run(run_options);
  constexpr std::size_t chunk = 256;
  run.loop(count, chunk, 1.0, [&]() -> RangeBody {
    return [&, search = ClosestSearch(bvh, options)](std::size_t begin, std::size_t end) mutable {
      for (std::size_t i = begin; i < end; ++i) {
        run.check();  // one point can take long: far away, or among faces that do not count
        hits.set(i, search(points.data() + 3 * i, normalOf(options, i)));
      }
    };
  });
  run.finish();
  countQueries(BackEnd::NATIVE, Query::CLOSEST_POINT, count);
  return hits;
}

}  // namespace mesh_map
