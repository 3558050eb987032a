#include "tools/selection/search_target.h"

#include <memory>
#include <utility>

#include <OgreViewport.h>
#include <rviz/viewport_mouse_event.h>

#include "picking/surface_index.h"
#include "picking/surface_picker.h"
#include "picking/view_geometry.h"

namespace rviz_mesh_plugin {

FaceSearch searchIn(const ShownMesh& shown, const rviz::ViewportMouseEvent& event,
                    const SelectionSettings& settings)
{
  FaceSearch search;
  search.shown = shown;
  search.queries = SurfaceIndex::instance().find(shown.mesh).queries;
  search.eye = eyeInMesh(*event.viewport->getCamera(), shown);
  search.visible_only = settings.visible_only;
  search.back_faces = settings.back_faces;
  return search;
}

FaceSearch searchInView(const ShownMesh& shown, const rviz::ViewportMouseEvent& event,
                        const SelectionSettings& settings)
{
  FaceSearch view = searchIn(shown, event, settings);
  view.regions.push_back(std::make_shared<mesh_map::ConvexRegion>(
      boxRegion({-1.0, -1.0}, {1.0, 1.0}, meshToClip(*event.viewport->getCamera(), shown))));
  return view;
}

SearchTarget selectedTarget(const SurfacePicker& picker, const MeshDataConstPtr& selected,
                            const rviz::ViewportMouseEvent& event,
                            const SelectionSettings& settings)
{
  if (!selected) {
    return {{}, NONE_SELECTED};
  }
  for (const ShownMesh& shown : picker.meshes()) {
    if (shown.mesh == selected) {
      FaceSearch search = searchIn(shown, event, settings);
      if (search.queries) {
        return {{std::move(search)}, {}};
      }
      return {{}, "the mesh is being prepared: try again in a moment"};
    }
  }
  return {{}, "the mesh with the selected faces is not shown: enable its display"};
}

SearchTarget areaTarget(const SurfacePicker& picker, const MeshDataConstPtr& selected,
                        const std::vector<Pixel>& path, const rviz::ViewportMouseEvent& event,
                        const SelectionSettings& settings)
{
  const auto [lower, upper] = boundsOf(path);
  rviz::ViewportMouseEvent middle = event;
  middle.x = (lower.x + upper.x) / 2;
  middle.y = (lower.y + upper.y) / 2;
  const Pick pick = picker.pick(middle, settings.back_faces);
  if (pick.hit) {
    return {{searchIn(*pick.hit, event, settings)}, {}};
  }
  SearchTarget target = selectedTarget(picker, selected, event, settings);
  if (!target.searches.empty()) {
    return target;
  }
  target = {};
  for (const ShownMesh& shown : picker.meshes()) {
    FaceSearch search = searchIn(shown, event, settings);
    if (search.queries) {
      target.searches.push_back(std::move(search));
    } else {
      target.reason = pick.reason;  // it may be there
    }
  }
  if (target.searches.empty()) {
    target.reason = pick.reason;
  }
  return target;
}

}  // namespace rviz_mesh_plugin
