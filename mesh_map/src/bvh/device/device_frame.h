#pragma once

#include <mesh_map/bvh/device/bvh_device.h>

#include <array>
#include <cmath>
#include <cstddef>

#include "bvh/rays/ray_search.h"

namespace mesh_map {

/// Meshes, rays and points with larger local coordinates are beyond the kernels: everything is in
/// doubt. Squares of these are floats.
constexpr double DEVICE_LARGEST = 1e17;

/// Bound of the error of some operations in double precision, relative to the size of the numbers.
constexpr double DEVICE_ROUNDING = 0x1p-48;

/// A float that is not less than a bound that is not negative; large ones are cut.
inline float roundedUp(double bound)
{
  return static_cast<float>(std::fmin(bound, 1e30) * (1.0 + 0x1p-22) + 1e-36);
}

/// The box of the mesh in local coordinates in double precision.
struct DeviceFrame
{
  explicit DeviceFrame(const Bvh& bvh);

  std::array<double, 3> center, lower, upper, reach;  ///< reach: largest coordinates
  double size = 0.0;                                  ///< largest extent
  bool usable = true;                                 ///< by kernels
};

/// Throws std::invalid_argument unless there are `per_item` answers for each of `count` items.
void checkAnswers(std::size_t answers, std::size_t count, std::size_t per_item);

}  // namespace mesh_map
