#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "base/face_bits.h"
#include "base/layer_info.h"
#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// From one number to another, both included. NaN lies in none.
struct ValueRange
{
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();

  bool contains(double value) const { return lower <= value && value <= upper; }
};

/// Faces by the values of a cost layer at their three vertices; of a layer of faces by their own.
struct LayerCriterion
{
  enum Values
  {
    RANGE,   ///< a finite cost in `range`
    LETHAL,  ///< as `info` says; always +inf
    UNKNOWN  ///< NaN
  };

  LayerCriterion(CostLayerConstPtr of_layer, LayerInfo of_info)
      : layer(std::move(of_layer)), info(std::move(of_info))
  {
  }

  CostLayerConstPtr layer;
  LayerInfo info;
  Values values = RANGE;
  ValueRange range;
  bool all_corners = true;  ///< all three vertices have such a value; false: one of them at least
};

/// By how high the middle of their three vertices lies, in meters: up * position + offset.
struct HeightCriterion
{
  std::array<double, 3> up{0.0, 0.0, 1.0};  ///< in the mesh, of length 1
  double offset = 0.0;
  ValueRange range;
};

/// By the angle between their normal (to the side from which they are counterclockwise) and what is
/// up, in radians: 0 of a floor, half pi of a wall, pi of a ceiling. Faces without an area have
/// none.
struct SlopeCriterion
{
  std::array<double, 3> up{0.0, 0.0, 1.0};  ///< in the mesh, of length 1
  ValueRange range;
};

/// These faces.
struct ListCriterion
{
  std::shared_ptr<const std::vector<std::uint32_t>> faces;
};

/// What faces are selected by.
using FaceCriterion = std::variant<LayerCriterion, HeightCriterion, SlopeCriterion, ListCriterion>;

/// The faces of a mesh that meet a criterion: looks at each of them, for a thread.
/// @throw std::invalid_argument where a layer has another size than the mesh, Canceled
/// (cancellation.h), std::bad_alloc
FaceBits facesThatMeet(const FaceCriterion& criterion, const MeshData& mesh,
                       const std::atomic<bool>* cancel = nullptr);

}  // namespace rviz_mesh_plugin
