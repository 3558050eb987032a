#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/mesh_data.h"
#include "measurement/surface_area.h"
#include "measurement/surface_profile.h"
#include "picking/surface_paths.h"

namespace rviz_mesh_plugin {

enum class MeasurementKind
{
  DISTANCE,  ///< between two points, straight and along the surface
  AREA,      ///< within an outline of three points or more
  PROFILE    ///< below the line between two points
};

/// "Distance", "Area", "Profile"
const char* nameOf(MeasurementKind kind);

/// What comes of a measurement; of its kind alone.
struct MeasuredSurface
{
  SurfacePath path;
  SurfaceArea area;
  SurfaceProfile profile;
};

/// Something measured on one mesh: in the frame of the mesh, in which z is up, in meters. It
/// belongs to the geometry alone; costs, colors and labels do not change it.
struct Measurement
{
  enum State
  {
    WAITING,
    DONE,
    FAILED
  };
  std::uint32_t number = 0;  ///< which no other one gets
  MeasurementKind kind = MeasurementKind::DISTANCE;
  std::string uuid;     ///< of the mesh
  std::string frame;    ///< of all coordinates
  std::string display;  ///< that showed the mesh
  std::vector<SurfacePoint> points;
  State state = WAITING;
  std::string error;  ///< FAILED: why
  MeasuredSurface result;
  bool stale = false;  ///< the mesh is gone
  std::weak_ptr<const MeshData> mesh;

  // Between the first and the last point.
  double straight() const;
  double plan() const;
  double rise() const;   ///< of z
  double slope() const;  ///< of the straight line, in radians; upwards is positive

  /// What it is about, in one line; the value that counts most.
  std::string value() const;
  /// All else that is known, in one line.
  std::string details() const;
  /// What stands beside its mark.
  std::vector<std::string> lines() const;
  /// What has to be known to believe it; else empty.
  std::string remark() const;
};

/// Not for the GUI thread. @throw Canceled (cancellation.h), std::bad_alloc, std::invalid_argument
/// that says what is wrong with the points
MeasuredSurface measure(const MeshData& mesh, MeasurementKind kind,
                        const std::vector<SurfacePoint>& points,
                        const std::atomic<bool>* cancel = nullptr);

}  // namespace rviz_mesh_plugin
