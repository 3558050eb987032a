#pragma once

#include <array>

#include <mesh_map/bvh/rays/bvh_rays.h>

namespace rviz_mesh_plugin {

/// Where something stands on a surface, in meters: its axes have length 1, are perpendicular and
/// right-handed; z is the normal of the surface.
struct SurfacePose
{
  std::array<double, 3> position{};
  std::array<double, 3> x{1, 0, 0};
  std::array<double, 3> y{0, 1, 0};
  std::array<double, 3> z{0, 0, 1};
};

/// x, y, z, w; of length 1.
std::array<double, 4> quaternionOf(const SurfacePose& pose);

/// To which side of the surface z shows.
struct SurfaceSide
{
  enum Of
  {
    VIEWER,
    UP  ///< that of +z of the coordinates; that of the viewer where the surface is vertical
  };
  Of of = VIEWER;
  bool switched = false;  ///< the other one: z and y are turned over
};

/// A camera, in the coordinates of the pose.
struct ViewAxes
{
  std::array<double, 3> forward{0, 0, -1};
  std::array<double, 3> up{0, 1, 0};
};

/// A pose that is put on a surface, and turned towards a cursor. Its axes are always valid.
class SurfacePoseDrag
{
 public:
  /// Looks as the camera does.
  /// @param normal of the surface, to either side, of any length but 0
  /// @param ray that has hit the surface there
  SurfacePoseDrag(const std::array<double, 3>& point, const std::array<double, 3>& normal,
                  const mesh_map::Ray& ray, const ViewAxes& view, const SurfaceSide& side);

  const SurfacePose& pose() const { return pose_; }

  /// Turns x along the view of the camera: to the top of the picture where it looks straight down.
  void turnAlong(const ViewAxes& view);

  /// Turns x towards the point where a ray meets the plane of the surface. Where it does not, as
  /// above the horizon, the pose stays; within a millimeter of the pose, it looks as the camera.
  void turnTowards(const mesh_map::Ray& ray, const ViewAxes& view);

 private:
  void setX(const std::array<double, 3>& along);

  SurfacePose pose_;
};

}  // namespace rviz_mesh_plugin
