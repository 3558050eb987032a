#ifndef MESH_MAP_SRC_FIELD_VALUES_H
#define MESH_MAP_SRC_FIELD_VALUES_H

#include <mesh_map/field_trace.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "vector3.h"

namespace mesh_map {

/// Thinner faces (sine of the angle between two sides, squared) have no direction.
constexpr double NO_AREA = 1e-20;

/// Labels and slowness, where the latter may be 1 everywhere.
template <bool HAS_COSTS>
class FieldValues
{
 public:
  explicit FieldValues(const SurfaceField& field)
      : labels_(field.labels.data()),
        slowness_(field.slowness.data()),
        limit_(std::min(field.limit, std::numeric_limits<double>::max()))
  {
  }

  double label(std::uint32_t v) const { return labels_[v]; }
  double slowness(std::uint32_t v) const { return HAS_COSTS ? double{slowness_[v]} : 1.0; }

  /// Open, and the front came there.
  bool isReached(std::uint32_t v) const { return isUpTo(v, std::numeric_limits<double>::max()); }
  bool isFinal(std::uint32_t v) const { return isUpTo(v, limit_); }

  double meanSlowness(std::uint32_t a, std::uint32_t b, std::uint32_t c) const
  {
    return HAS_COSTS ? (slowness(a) + slowness(b) + slowness(c)) * (1.0 / 3.0) : 1.0;
  }

 private:
  bool isUpTo(std::uint32_t v, double most) const
  {
    return labels_[v] >= 0.0 && labels_[v] <= most && (!HAS_COSTS || std::isfinite(slowness_[v]));
  }

  const double* labels_;
  const float* slowness_;
  double limit_;
};

/// The unit vector as floats; zeros where it is not longer than `least`, squared.
inline void storeUnit(const Vector3& vector, double least, float* out)
{
  const double squared = dot(vector, vector);
  const double factor = squared > least && std::isfinite(squared) ? 1.0 / std::sqrt(squared) : 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = static_cast<float>(factor * vector[i]);
  }
}

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_FIELD_VALUES_H
