#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

struct SurfacePoint
{
  std::uint32_t face = 0;
  std::array<double, 3> position{};  ///< in the face, in the coordinates of the mesh
};

struct SurfacePath
{
  bool connected = false;      ///< false: there is no way, nor length
  double length = 0.0;         ///< in meters
  std::vector<double> points;  ///< 3 each, from start to end; straight in between
};

/// The way that a wave front takes over the surface of a mesh, pulled taut: no way near it is
/// shorter, and it is the shortest of all but for those that hardly differ. It crosses seams, where
/// vertices in the same place are several. Takes about a second for some million faces, and about
/// 200 bytes for each of them.
/// @throw Canceled (cancellation.h), std::bad_alloc, std::invalid_argument for points that are not
/// in their faces
SurfacePath findPath(const MeshData& mesh, const SurfacePoint& from, const SurfacePoint& to,
                     const std::atomic<bool>* cancel = nullptr);

}  // namespace rviz_mesh_plugin
