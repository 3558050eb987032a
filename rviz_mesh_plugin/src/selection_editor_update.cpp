#include <utility>

#include "rviz_mesh_plugin/brush_path.h"
#include "rviz_mesh_plugin/face_neighbors.h"
#include "rviz_mesh_plugin/selection_editor.h"
#include "rviz_mesh_plugin/surface_index.h"

namespace rviz_mesh_plugin {
void SelectionEditor::beginStroke()
{
  session_.beginStroke();
  stroking_ = true;
  stroke_ending_ = false;
  stroke_mesh_.reset();
  brush_.reset();
}

void SelectionEditor::endStroke()
{
  stroke_ending_ = stroking_;
  finishStroke();
}

/// With its last answer.
void SelectionEditor::finishStroke()
{
  if (stroke_ending_ && !busy()) {
    session_.endStroke();
    stroking_ = stroke_ending_ = false;
    stroke_mesh_.reset();
  }
}

void SelectionEditor::findBrush(const Event& event, const SelectionSettings& settings)
{
  brush_ = picker_.pick(event, settings.back_faces).hit;
}

std::string SelectionEditor::stroke(const Event& event, const Gesture& gesture,
                                    const SelectionSettings& settings)
{
  BrushPath path =
      followBrush(picker_, event, gesture, std::exchange(brush_, std::nullopt), settings);
  brush_ = std::move(path.last);
  const auto& hits = path.hits;
  if (hits.empty()) {
    return picker_.pick(event, settings.back_faces).reason;
  }
  if (!stroke_mesh_) {
    stroke_mesh_ = gesture.adding ? hits.front().mesh : session_.mesh();
  }
  FaceSearch search;
  for (const SurfaceHit& hit : hits) {
    if (hit.mesh == stroke_mesh_) {
      if (search.regions.empty()) {
        search = makeSearch(event, hit, settings);
      }
      search.regions.push_back(
          std::make_shared<mesh_map::SphereRegion>(hit.point, settings.radius));
    }
  }
  if (search.regions.empty()) {
    return stroke_mesh_ ? "the brush stays on the mesh that it touched first"
                        : "nothing is selected that could be deselected";
  }
  return this->search(std::move(search), gesture.adding, settings.visible_only);
}

std::string SelectionEditor::change(
    const std::function<const FaceSelection::Change&(FaceSelection&)>& make)
{
  if (!session_.mesh()) {
    return "nothing has been selected yet: show a mesh, and click at it";
  }
  session_.change(make);
  return {};
}

std::string SelectionEditor::selectAll()
{
  if (!session_.mesh()) {
    const auto shown = picker_.meshes();
    session_.setMesh(shown.empty() ? nullptr : shown.front().mesh);
  }
  return change([](FaceSelection& selection) -> const FaceSelection::Change& {
    return selection.selectAll();
  });
}

std::string SelectionEditor::replace(const MeshDataConstPtr& mesh,
                                     const FaceSelection::Faces& faces)
{
  if (!mesh || !picker_.exists(mesh)) {
    return "no display has this mesh (any more): add a TexturedMesh or Map3D display that shows it";
  }
  giveUp();
  session_.setMesh(mesh);
  session_.change([&](FaceSelection& selection) -> const FaceSelection::Change& {
    return selection.replace(faces);
  });
  return {};
}

std::shared_ptr<const FaceNeighbors> SelectionEditor::neighborsOf(const MeshDataConstPtr& mesh,
                                                                  std::string& reason)
{
  const auto state = SurfaceIndex::instance().findNeighbors(mesh);
  if (!state.neighbors) {
    reason = state.failure.empty()
                 ? "which faces lie beside each other is being found out: try again in a moment"
                 : "which faces lie beside each other cannot be told: " + state.failure;
  }
  return state.neighbors;
}

std::string SelectionEditor::growOrShrink(bool grow)
{
  if (!session_.mesh() || session_.selection().empty()) {
    return "nothing is selected that could grow or shrink";
  }
  std::string reason;
  const auto neighbors = neighborsOf(session_.mesh(), reason);
  if (!neighbors) {
    return reason;
  }
  return change([&](FaceSelection& selection) -> const FaceSelection::Change& {
    return grow ? selection.select(neighbors->grow(selection))
                : selection.deselect(neighbors->shrink(selection));
  });
}

bool SelectionEditor::giveUp()
{
  const bool searching = query_.giveUp();
  const bool stroking = std::exchange(stroking_, false);
  stroke_ending_ = false;
  stroke_mesh_.reset();
  if (stroking && session_.selection().inStroke()) {
    session_.change([](FaceSelection& selection) -> const FaceSelection::Change& {
      return selection.giveUpStroke();
    });
  }
  return searching || stroking;
}

void SelectionEditor::prepare(const SelectionSettings& settings)
{
  picker_.prepare();
  const auto meshes = picker_.meshes();
  if (meshes.size() == 1 && !session_.mesh() && !stroking_) {
    session_.setMesh(meshes.front().mesh);  // its vertices are uploaded then
  }
  for (const ShownMesh& shown : meshes) {
    if (settings.technique == SelectionTechnique::FLOOD) {
      SurfaceIndex::instance().findNeighbors(shown.mesh);
    }
  }
}

SelectionEditor::News SelectionEditor::dropLostMesh()
{
  const auto is_gone = [this](const MeshDataConstPtr& mesh) {
    return mesh && !picker_.exists(mesh);
  };
  News news;
  if (is_gone(stroke_mesh_)) {
    giveUp();
    news = {"the mesh is gone that the brush was on", true};
  }
  if (brush_ && is_gone(brush_->mesh)) {
    brush_.reset();
  }
  if (is_gone(session_.mesh())) {
    const std::size_t lost = session_.selection().count();
    giveUp();
    session_.setMesh(nullptr);
    news.mesh_gone = true;
    if (lost > 0) {
      news.text = "the mesh is gone of which " + std::to_string(lost) + " faces were selected";
    }
  }
  return news;
}

SelectionEditor::News SelectionEditor::frame()
{
  News news = dropLostMesh();
  while (auto answer = query_.take()) {
    if (!answer->failure.empty()) {
      news.text = "faces could not be found: " + answer->failure;
    } else if (!picker_.exists(answer->mesh)) {
      news.text = "the mesh is gone of which faces were looked for";
    } else {
      const std::string text = apply(answer->mesh, answer->adding, answer->faces);
      news.text = text.empty() ? news.text : text;
    }
  }
  finishStroke();
  session_.follow(picker_.meshes());
  return news;
}

}  // namespace rviz_mesh_plugin
