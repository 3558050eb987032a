#include "reconstruction/measured_rays.h"

#include <algorithm>
#include <cmath>

namespace mesh_map {
namespace {

constexpr float TYPICAL_RANGE = 10.0f;  // m from which on a point counts clearly less
constexpr float LEAST_COSINE = 0.1f;    // of the incidence: its weight is never below
constexpr float STEEP_COSINE = 0.8f;    // of the incidence, above which ray and normal are one way
constexpr double MOST_REACH = 2.0;      // truncations that a part reaches from the point
constexpr double NEAREST_POINT = 0.01;  // voxels from the sensor; nearer ones have no direction

/// From the sensor to a point.
struct Beam
{
  Beam(const Vector3f& point, const Vector3f& sensor) : direction(along(point, -1, sensor))
  {
    length = std::sqrt(dot(direction, direction));
    const float scale = 1 / length;
    direction = {scale * direction[0], scale * direction[1], scale * direction[2]};
  }

  Vector3f direction;
  float length;
};

/// Cosine of the angle between ray and normal, as far as it counts.
float incidence(const Vector3f& normal, const Vector3f& direction)
{
  return std::max(-dot(normal, direction), LEAST_COSINE);
}

RayParts partsOf(const MeasuredRay& ray, const Beam& beam, float truncation)
{
  const float cosine = incidence(ray.normal, beam.direction);
  // Where a ray grazes the ground, what it tells of that reaches farther: less of the ground
  // between the rings of a lidar stays open.
  const float reach = truncation * std::min(1 / cosine, static_cast<float>(MOST_REACH));
  RayParts parts;
  parts.front = along(ray.point, -std::min(reach, beam.length), beam.direction);
  parts.back = along(ray.point, reach, beam.direction);
  parts.is_grazing = cosine < STEEP_COSINE;
  if (parts.is_grazing) {
    parts.outside = along(ray.point, truncation, ray.normal);
    parts.inside = along(ray.point, -truncation, ray.normal);
  }
  return parts;
}

}  // namespace

MeasuredRays::MeasuredRays(const FieldOptions& options, const MeasuredPoints& measured,
                           std::size_t begin, std::size_t end)
    : options_(options),
      measured_(measured),
      begin_(begin),
      per_meter_(static_cast<float>(1 / options.voxel_size)),
      truncation_(static_cast<float>(options.truncation / options.voxel_size)),
      rays_(end - begin)
{
}

Vector3f MeasuredRays::sensor(std::size_t ray) const
{
  const bool is_one = measured_.origins.size() == 3;
  const float* const origin = measured_.origins.data() + (is_one ? 0 : 3 * point(ray));
  return {origin[0] * per_meter_, origin[1] * per_meter_, origin[2] * per_meter_};
}

IntegrationCounts MeasuredRays::make(std::size_t begin, std::size_t end)
{
  const double least = std::max(options_.min_range, NEAREST_POINT * options_.voxel_size);
  const auto least_square = static_cast<float>(least * least);
  const double most_square = options_.max_range * options_.max_range;
  // All that a part reaches is within the grid.
  const auto limit = static_cast<float>(GridPlace::LIMIT - 2 - MOST_REACH * double{truncation_});
  const bool is_one = measured_.origins.size() == 3;
  IntegrationCounts counts;
  for (std::size_t i = begin; i < end; ++i) {
    const float* const at = measured_.points.data() + 3 * point(i);
    const float* const origin = measured_.origins.data() + (is_one ? 0 : 3 * point(i));
    MeasuredRay& ray = rays_[i];
    float square = 0;
    bool is_inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
      ray.point[k] = at[k] * per_meter_;
      square += (at[k] - origin[k]) * (at[k] - origin[k]);
      is_inside =
          is_inside && std::abs(ray.point[k]) < limit && std::abs(origin[k] * per_meter_) < limit;
    }
    if (!std::isfinite(square)) {
      ++counts.not_finite;
    } else if (square < least_square) {
      ++counts.too_near;
    } else if (square > most_square) {
      ++counts.too_far;
    } else if (!is_inside) {
      ++counts.outside;
    } else {
      ++counts.used;
      const float range = std::sqrt(square) / TYPICAL_RANGE;
      ray.weight = 1 / (1 + range * range);
    }
  }
  return counts;
}

RayParts MeasuredRays::aim(std::size_t number, const PointNormal& around)
{
  MeasuredRay& ray = rays_[number];
  const Beam beam(ray.point, sensor(number));
  const Vector3f plane = {around.x, around.y, around.z};
  const float towards = dot(plane, beam.direction) > 0 ? -around.flatness : around.flatness;
  Vector3f mixed;
  for (std::size_t k = 0; k < 3; ++k) {
    mixed[k] = towards * plane[k] - (1 - around.flatness) * beam.direction[k];
  }
  const float square = dot(mixed, mixed), scale = 1 / std::sqrt(square);
  ray.normal = {scale * mixed[0], scale * mixed[1], scale * mixed[2]};
  if (!(square > 0 && std::isfinite(square))) {  // only by a state that was tampered with
    ray.normal = along({0, 0, 0}, -1, beam.direction);
  }
  // A beam that grazes a surface lights a long spot on it, and tells less of its distance; on the
  // other hand the error of its range moves the point along the surface.
  ray.weight *= std::sqrt(incidence(ray.normal, beam.direction));
  return partsOf(ray, beam, truncation_);
}

RayParts MeasuredRays::parts(std::size_t number) const
{
  return partsOf(rays_[number], Beam(rays_[number].point, sensor(number)), truncation_);
}

}  // namespace mesh_map
