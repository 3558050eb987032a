#include "rviz_mesh_plugin/selection_editor.h"

#include <algorithm>
#include <utility>

#include <OgreViewport.h>
#include <rviz/display_context.h>

#include "rviz_mesh_plugin/face_neighbors.h"
#include "rviz_mesh_plugin/label_lookup.h"
#include "rviz_mesh_plugin/selection_regions.h"
#include "rviz_mesh_plugin/surface_index.h"

namespace rviz_mesh_plugin {
namespace {

constexpr const char* NOTHING_THERE = "there are no faces to be selected there";
constexpr const char* NONE_SELECTED = "nothing is selected there that could be deselected";

}  // namespace

SelectionEditor::SelectionEditor(rviz::DisplayContext* context,
                                 const std::function<void()>& on_change)
    : context_(context), picker_(context), session_(context->getSceneManager(), on_change)
{
}

std::string SelectionEditor::click(const Event& event, const Gesture& gesture,
                                   const SelectionSettings& settings)
{
  const Pick pick = picker_.pick(event, settings.back_faces);
  if (!pick.hit) {
    return pick.reason;
  }
  const MeshDataConstPtr& mesh = pick.hit->mesh;
  if (!gesture.adding && mesh != session_.mesh()) {
    return NONE_SELECTED;
  }
  if (settings.technique == SelectionTechnique::FLOOD) {
    return flood(*pick.hit, gesture.adding, settings);
  }
  if (settings.technique == SelectionTechnique::LABEL) {
    const auto label = labelAt(context_->getRootDisplayGroup(), *mesh, pick.hit->face);
    return label ? apply(mesh, gesture.adding, label->faces)
                 : "this face has no label, or no ClusterLabel display is enabled that shows it";
  }
  return apply(mesh, gesture.adding, {pick.hit->face});
}

std::string SelectionEditor::flood(const SurfaceHit& hit, bool adding,
                                   const SelectionSettings& settings)
{
  std::string reason;
  auto neighbors = neighborsOf(hit.mesh, reason);
  if (neighbors) {
    query_.ask(hit.mesh, adding,
               [neighbors = std::move(neighbors), mesh = hit.mesh, face = hit.face,
                angle = settings.flood_angle](const std::atomic<bool>& cancel) {
                 return neighbors->flood(*mesh, face, angle, &cancel);
               });
  }
  return reason;
}

std::string SelectionEditor::box(const Event& event, const Gesture& gesture,
                                 const SelectionSettings& settings)
{
  Target target = findTarget(event, gesture, {gesture.from, gesture.to}, settings);
  if (!target.reason.empty()) {
    return target.reason;
  }
  target.search.regions.push_back(std::make_shared<mesh_map::ConvexRegion>(
      boxRegion(pointOf(gesture.from, *event.viewport), pointOf(gesture.to, *event.viewport),
                meshToClip(*event.viewport->getCamera(), target.search.shown))));
  return search(std::move(target.search), gesture.adding, settings.visible_only);
}

std::string SelectionEditor::lasso(const Event& event, const Gesture& gesture,
                                   const std::vector<Pixel>& path,
                                   const SelectionSettings& settings)
{
  Target target = findTarget(event, gesture, path, settings);
  if (!target.reason.empty()) {
    return target.reason;
  }
  target.search.regions.push_back(std::make_shared<mesh_map::LassoRegion>(
      pointsOf(path, *event.viewport),
      meshToClip(*event.viewport->getCamera(), target.search.shown)));
  return search(std::move(target.search), gesture.adding, true);
}

FaceSearch SelectionEditor::makeSearch(const Event& event, const ShownMesh& shown,
                                       const SelectionSettings& settings) const
{
  FaceSearch search;
  search.shown = shown;
  search.queries = SurfaceIndex::instance().find(shown.mesh).queries;
  search.eye = eyeInMesh(*event.viewport->getCamera(), shown);
  search.visible_only = settings.visible_only;
  search.back_faces = settings.back_faces;
  return search;
}

/// The mesh that has a selection.
SelectionEditor::Target SelectionEditor::selectedTarget(const Event& event,
                                                        const SelectionSettings& settings) const
{
  if (!session_.mesh() || session_.selection().empty()) {
    return {{}, NONE_SELECTED};
  }
  for (const ShownMesh& shown : picker_.meshes()) {
    if (shown.mesh == session_.mesh()) {
      Target target{makeSearch(event, shown, settings), {}};
      if (!target.search.queries) {
        target.reason = "the mesh is being prepared: try again in a moment";
      }
      return target;
    }
  }
  return {{}, "the mesh with the selected faces is hidden: enable its display"};
}

/// The mesh in the middle of a part of the picture, else the one that has a selection, else the
/// first that has faces there.
SelectionEditor::Target SelectionEditor::findTarget(const Event& event, const Gesture& gesture,
                                                    const std::vector<Pixel>& bounds,
                                                    const SelectionSettings& settings) const
{
  if (!gesture.adding) {
    return selectedTarget(event, settings);
  }
  Pixel lower = bounds.front(), upper = lower;
  for (const Pixel& pixel : bounds) {
    lower = {std::min(lower.x, pixel.x), std::min(lower.y, pixel.y)};
    upper = {std::max(upper.x, pixel.x), std::max(upper.y, pixel.y)};
  }
  Event middle = event;
  middle.x = (lower.x + upper.x) / 2;
  middle.y = (lower.y + upper.y) / 2;
  const Pick pick = picker_.pick(middle, settings.back_faces);
  if (pick.hit) {
    return {makeSearch(event, *pick.hit, settings), {}};
  }
  Target target = selectedTarget(event, settings);
  if (target.reason.empty()) {
    return target;
  }
  const auto& viewport = *event.viewport;
  bool all_ready = true;
  for (const ShownMesh& shown : picker_.meshes()) {
    target = {makeSearch(event, shown, settings), {}};
    all_ready = all_ready && target.search.queries;
    if (target.search.queries &&
        !target.search.queries
             ->selectFaces(boxRegion(pointOf(lower, viewport), pointOf(upper, viewport),
                                     meshToClip(*viewport.getCamera(), shown)))
             .empty()) {
      return target;
    }
  }
  const bool none_there = all_ready && target.search.shown.mesh;
  return {{}, none_there ? NOTHING_THERE : pick.reason};
}

std::string SelectionEditor::search(FaceSearch search, bool adding, bool on_thread)
{
  const MeshDataConstPtr mesh = search.shown.mesh;
  if (!on_thread) {
    return apply(mesh, adding, search());
  }
  query_.ask(mesh, adding, [search = std::move(search)](const std::atomic<bool>& cancel) {
    return search(&cancel);
  });
  return {};
}

std::string SelectionEditor::apply(const MeshDataConstPtr& mesh, bool adding,
                                   const FaceSelection::Faces& faces)
{
  std::string text;
  if (faces.empty()) {
    return stroking_ ? text : NOTHING_THERE;
  }
  if (mesh != session_.mesh()) {
    if (!adding) {
      return NONE_SELECTED;
    }
    if (const std::size_t lost = session_.selection().count()) {
      text = "this is another mesh: " + std::to_string(lost) +
             " faces of the one before are not selected any more";
    }
    session_.setMesh(mesh);
    if (stroking_) {
      session_.beginStroke();
    }
  }
  session_.change([&](FaceSelection& selection) -> const FaceSelection::Change& {
    return adding ? selection.select(faces) : selection.deselect(faces);
  });
  return text;
}

}  // namespace rviz_mesh_plugin
