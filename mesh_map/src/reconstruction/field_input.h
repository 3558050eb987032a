#pragma once

#include <mesh_map/base/array_view.h>

#include <cstddef>
#include <cstdint>
#include <limits>

namespace mesh_map {

/// How a field is made. Lengths in m.
struct FieldOptions
{
  double voxel_size = 0.1;
  double truncation = 0.2;  ///< distances are kept up to it
  double min_range = 0.0, max_range = std::numeric_limits<double>::infinity();
  bool carve = false;  ///< what rays pass through is emptied again, up to where they end
  bool colors = false, intensities = false;
  std::size_t memory_limit = std::numeric_limits<std::size_t>::max();  ///< bytes
};

/// Points and from where they were measured, in the frame of the field.
struct MeasuredPoints
{
  ArrayView<float> points, origins;  ///< x, y, z each; origins of all points, or one for all
  ArrayView<std::uint8_t> colors;    ///< red, green, blue each, or none
  ArrayView<float> intensities;      ///< or none
};

/// What became of points.
struct IntegrationCounts
{
  std::size_t used = 0, not_finite = 0, too_near = 0, too_far = 0, outside = 0;

  IntegrationCounts& operator+=(const IntegrationCounts& other)
  {
    used += other.used;
    not_finite += other.not_finite;
    too_near += other.too_near;
    too_far += other.too_far;
    outside += other.outside;
    return *this;
  }
};

}  // namespace mesh_map
