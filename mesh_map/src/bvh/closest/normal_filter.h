#pragma once

#include "base/vector3.h"

namespace mesh_map {

/// Which triangles have a normal within an angle of a direction, in double precision; 1e-12 radians
/// more count as rounding.
class NormalFilter
{
 public:
  /// All have.
  NormalFilter() = default;

  /// Of a direction of any length.
  NormalFilter(const double* direction, double max_angle);

  /// False: for a direction or an angle for which no triangle can count.
  bool valid() const { return valid_; }

  bool operator()(const float* corners) const { return all_ || within(corners); }

 private:
  bool within(const float* corners) const;

  bool valid_ = true, all_ = true;
  Vector3 direction_{};
  double max_angle_ = 0.0, cosine_ = 0.0;
};

}  // namespace mesh_map
