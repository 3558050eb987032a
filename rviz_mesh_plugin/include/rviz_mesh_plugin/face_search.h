#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <vector>

#include "rviz_mesh_plugin/face_selection.h"
#include "rviz_mesh_plugin/shown_mesh.h"
#include "rviz_mesh_plugin/spatial_queries.h"

namespace rviz_mesh_plugin {

/// Which faces of a mesh are to be found; owns what it needs, for any thread.
struct FaceSearch
{
  ShownMesh shown;
  std::shared_ptr<const SpatialQueries> queries;
  std::vector<std::shared_ptr<const mesh_map::Region>> regions;  ///< what touches one of them
  std::array<double, 3> eye{};                                   ///< in the mesh
  bool visible_only = false;                                     ///< what the eye sees
  bool back_faces = true;                                        ///< false: not those from behind

  /// A face that touches several regions is named for each.
  /// @throw mesh_map::Cancelled, std::bad_alloc
  FaceSelection::Faces operator()(const std::atomic<bool>* cancel = nullptr) const;
};

}  // namespace rviz_mesh_plugin
