#pragma once

#include <string>

#include "base/hidden_faces.h"
#include "base/mesh_data.h"
#include "base/section.h"
#include "rendering/placed_visual.h"
#include "sources/mesh_source.h"

namespace rviz_mesh_plugin {

/// A mesh as it lies in the fixed frame, and who shows it.
struct ShownMesh : FramePose
{
  MeshDataConstPtr mesh;
  std::string display;           ///< its name
  MeshSource source;             ///< of the display; its labels are in labelNamespace() of it
  Section section{};             ///< what is seen of it
  HiddenFacesConstPtr hidden{};  ///< null: none
};

}  // namespace rviz_mesh_plugin
