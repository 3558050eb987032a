#include "rviz_mesh_plugin/face_search.h"

#include <utility>

#include "rviz_mesh_plugin/selection_regions.h"

namespace rviz_mesh_plugin {

FaceSelection::Faces FaceSearch::operator()(const std::atomic<bool>* cancel) const
{
  mesh_map::BvhOptions run;
  run.cancel = cancel;
  FaceSelection::Faces all;
  for (const auto& region : regions) {
    auto faces = queries->selectFaces(*region, mesh_map::SelectionMode::TOUCHING, {}, run);
    if (!back_faces) {
      dropBackFaces(*shown.mesh, eye, faces);
    }
    if (visible_only) {
      faces = queries->seenFaces(*region, faces, eye, run);
    }
    if (all.empty()) {
      all = std::move(faces);
    } else {
      all.insert(all.end(), faces.begin(), faces.end());
    }
  }
  return all;
}

}  // namespace rviz_mesh_plugin
