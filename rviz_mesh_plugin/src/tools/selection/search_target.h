#pragma once

#include <string>
#include <vector>

#include "base/mesh_data.h"
#include "mesh_view/shown_mesh.h"
#include "selection/selection_gestures.h"
#include "selection/selection_regions.h"
#include "tools/selection/selection_properties.h"

namespace rviz {
class ViewportMouseEvent;
}

namespace rviz_mesh_plugin {

class SurfacePicker;

constexpr const char* NONE_SELECTED = "nothing is selected there that could be deselected";

/// In which meshes faces are looked for that somebody points at in a picture. GUI thread only.
struct SearchTarget
{
  /// The first one with faces counts; without regions.
  std::vector<FaceSearch> searches;
  std::string reason;  ///< why there is none, or why nothing is found
};

/// In a mesh as it is shown; without regions, and without queries while it is being prepared.
FaceSearch searchIn(const ShownMesh& shown, const rviz::ViewportMouseEvent& event,
                    const SelectionSettings& settings);
/// What is seen of the mesh in the whole picture.
FaceSearch searchInView(const ShownMesh& shown, const rviz::ViewportMouseEvent& event,
                        const SelectionSettings& settings);

/// The mesh that has a selection. @param selected null: none has
SearchTarget selectedTarget(const SurfacePicker& picker, const MeshDataConstPtr& selected,
                            const rviz::ViewportMouseEvent& event,
                            const SelectionSettings& settings);

/// The mesh in the middle of a part of the picture, else the one that has a selection, else all.
/// @param path around that part
SearchTarget areaTarget(const SurfacePicker& picker, const MeshDataConstPtr& selected,
                        const std::vector<Pixel>& path, const rviz::ViewportMouseEvent& event,
                        const SelectionSettings& settings);

}  // namespace rviz_mesh_plugin
