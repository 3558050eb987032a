#include "ray_search.h"

#include <mesh_map/back_end.h>

#include <string>

namespace mesh_map {

void checkMask(const Bvh& bvh, const RayOptions& options)
{
  if (!options.mask.empty() && options.mask.size() != bvh.faceCount()) {
    throw std::invalid_argument("a mask of " + std::to_string(options.mask.size()) +
                                " entries does not fit a mesh of " +
                                std::to_string(bvh.faceCount()) + " faces: one per face, or none");
  }
}

RayHit castRay(const Bvh& bvh, const Ray& ray, const RayOptions& options)
{
  checkMask(bvh, options);
  countQueries(BackEnd::NATIVE, Query::RAY, 1);
  RaySearch search(bvh, ray);
  searchAll<false>(bvh, options, search);
  return search.hit();
}

bool rayHitsAny(const Bvh& bvh, const Ray& ray, const RayOptions& options)
{
  checkMask(bvh, options);
  countQueries(BackEnd::NATIVE, Query::RAY, 1);
  RaySearch search(bvh, ray);
  searchAll<true>(bvh, options, search);
  return search.best.face != NO_INDEX;
}

}  // namespace mesh_map
