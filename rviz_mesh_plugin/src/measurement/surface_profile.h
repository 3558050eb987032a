#pragma once

#include <array>
#include <atomic>
#include <vector>

#include "base/mesh_data.h"
#include "picking/surface_paths.h"

namespace rviz_mesh_plugin {

/// The section of a surface below the straight line between two points in plan, in meters and in
/// the frame of the mesh, in which z is up.
struct SurfaceProfile
{
  struct Point
  {
    double distance = 0.0;  ///< in plan, from the first of the two points
    double z = 0.0;
  };
  using Piece = std::vector<Point>;  ///< straight between its points; at least two

  double length = 0.0;                ///< between the two points in plan
  bool connected = false;             ///< the surface leads from one to the other without a gap
  std::vector<Piece> pieces;          ///< in their order from the first point on
  std::array<double, 2> from{};       ///< x, y of the first point
  std::array<double, 2> direction{};  ///< of the line in plan, of length 1

  struct Gap
  {
    double begin = 0.0;  ///< from where to where along the line
    double end = 0.0;
    double step = 0.0;  ///< of z over it; unknown before the first piece and behind the last
  };
  /// Where there is none of the surface; of length 0 where one piece begins above or below where
  /// the other has ended.
  std::vector<Gap> gaps() const;

  struct Heights
  {
    double lowest = 0.0;
    double highest = 0.0;
    double ascent = 0.0;   ///< of all that goes up, along the pieces
    double descent = 0.0;  ///< of all that goes down
    double surface = 0.0;  ///< length of the pieces
  };
  /// Zeros where there are no pieces.
  Heights heights() const;
  std::array<double, 3> position(const Point& point) const
  {
    return {from[0] + point.distance * direction[0], from[1] + point.distance * direction[1],
            point.z};
  }
};

/// Of the surface that both points are on. Where its section leads from one to the other, that is
/// the profile (the shortest way, where it branches), with upright and overhanging parts. Else
/// there are gaps: from each end it goes as far along the line as the surface leads, and between
/// the two lies what belongs to the same connected surface, looks to the same side, is within the
/// gap and nearest to the straight line over it; where the two lie one above the other, there is a
/// gap, too. Surfaces that touch in the section within a millimeter are connected, as parts of a
/// CAD model are, and the way does not lead below a part that stands on another. Faces within the
/// upright plane count as those beside it.
/// @throw Canceled (cancellation.h), std::bad_alloc, std::invalid_argument where one point lies
/// above the other
SurfaceProfile findProfile(const MeshData& mesh, const SurfacePoint& from, const SurfacePoint& to,
                           const std::atomic<bool>* cancel = nullptr);

}  // namespace rviz_mesh_plugin
