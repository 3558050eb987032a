#pragma once

#include <atomic>
#include <vector>

#include "base/mesh_data.h"
#include "picking/surface_paths.h"

namespace rviz_mesh_plugin {

/// The surface within an outline, in square meters.
struct SurfaceArea
{
  double surface = 0.0;  ///< of faces, but walls
  double walls = 0.0;    ///< of faces that stand upright to within 5 degrees
  double plan = 0.0;     ///< of the outline, in plan (projected on x and y)
  double uncovered =
      0.0;                ///< of the outline, as it is looked at: what none of the surface is below
  double doubled = 0.0;   ///< as it is looked at: what is above or below other parts of it
  double outline = 0.0;   ///< length of the straight lines between its corners, in meters
  bool steep = false;     ///< the outline is looked at along its normal, since it is steep
  bool connected = true;  ///< one surface has all corners
};

/// Of the connected surface that the corners are on, which lies within the outline seen from above:
/// from face to face as long as the edge between them is within, and up to where it turns over, so
/// that what lies above or below does not count. An outline steeper than 60 degrees, as on a wall,
/// is looked at along its own normal (Newell's). Faces are cut exactly at the outline.
/// @param corners at least three, in their order, closed by itself
/// @throw Canceled (cancellation.h), std::bad_alloc, std::invalid_argument for an outline without
/// area, or that crosses itself
SurfaceArea findArea(const MeshData& mesh, const std::vector<SurfacePoint>& corners,
                     const std::atomic<bool>* cancel = nullptr);

}  // namespace rviz_mesh_plugin
