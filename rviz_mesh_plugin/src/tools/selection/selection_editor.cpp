#include "tools/selection/selection_editor.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <utility>

#include <OgreViewport.h>
#include <rviz/display_context.h>

#include "mesh_view/selectable_faces.h"
#include "picking/label_lookup.h"
#include "picking/surface_index.h"
#include "rendering/labels/label_parts.h"
#include "selection/face_neighbors.h"
#include "tools/selection/brush_stroke.h"
#include "tools/selection/face_hiding.h"
#include "tools/selection/frozen_view.h"
#include "tools/selection/search_target.h"

namespace rviz_mesh_plugin {
namespace {

constexpr const char* NOTHING_THERE = "there are no faces to be selected there";
constexpr const char* NO_MESH = "nothing has been selected yet: show a mesh, and click at it";
constexpr const char* GONE =
    "no display has this mesh (any more): add a TexturedMesh or Map3D display that shows it";
constexpr const char* NO_SUCH_FACES = "the mesh has no such faces";

/// Faces that are seen, and the one that was clicked at, which is, however little shows of it.
FaceBits withFace(const FaceSelection::Faces& seen, std::uint32_t clicked, const MeshData& mesh)
{
  FaceBits faces(mesh.faceCount(), seen);
  faces.add({clicked});
  return faces;
}

}  // namespace

SelectionEditor::SelectionEditor(rviz::DisplayContext* context, const SurfacePicker& picker,
                                 const std::function<void()>& on_change)
    : context_(context),
      picker_(picker),
      session_(context->getSceneManager(), on_change),
      hiding_(std::make_shared<FaceHiding>(picker))
{
  histories_.add(hiding_);
}

std::string SelectionEditor::click(const Event& event, const Gesture& gesture,
                                   const SelectionSettings& settings)
{
  Edit edit;
  edit.begin = [this, view = std::make_shared<const FrozenView>(event), adding = gesture.adding,
                settings](Edit& begun) {
    return beginClick(begun, view->event(), adding, settings);
  };
  return queue_.perform(std::move(edit));
}

std::string SelectionEditor::beginClick(Edit& edit, const Event& event, bool adding,
                                        const SelectionSettings& settings)
{
  const Pick pick = picker_.pick(event, settings.back_faces);
  if (!pick.hit) {
    return pick.reason;
  }
  const MeshDataConstPtr& mesh = pick.hit->mesh;
  if (!adding && mesh != session_.mesh()) {
    return NONE_SELECTED;
  }
  edit.mesh = adding ? mesh : nullptr;
  if (settings.technique == SelectionTechnique::FLOOD) {
    return beginFlood(edit, event, *pick.hit, adding, settings);
  }
  if (settings.technique != SelectionTechnique::LABEL) {
    put(edit, mesh, adding, std::make_shared<const FaceSelection::Faces>(1, pick.hit->face));
    return {};
  }
  const auto label = labelAt(context_->getRootDisplayGroup(), *mesh, pick.hit->face);
  if (!label) {
    return "this face has no label, or no ClusterLabel display is enabled that shows it";
  }
  putLabel(edit, event, *pick.hit, adding, LabelFacesConstPtr(label, &label->faces), settings);
  return {};
}

/// Where only faces count that are seen, it goes from one of these to the next.
std::string SelectionEditor::beginFlood(Edit& edit, const Event& event, const SurfaceHit& hit,
                                        bool adding, const SelectionSettings& settings)
{
  std::string reason;
  auto neighbors = neighborsOf(hit.mesh, reason);
  if (!neighbors) {
    edit.later = reason.empty();
    return reason;
  }
  edit.found =
      queue_.ask([neighbors = std::move(neighbors), view = searchInView(hit, event, settings),
                  face = hit.face, angle = settings.flood_angle](const std::atomic<bool>& cancel) {
        const MeshDataConstPtr& mesh = view.shown.mesh;
        const SelectableFaces selectable(view.shown);
        auto region = neighbors->flood(*mesh, face, angle, &selectable, nullptr, &cancel);
        if (view.choosesBySight()) {  // of what cannot be reached at all, nobody has to know
          const FaceBits open = withFace(view.chosenOf(std::move(region), &cancel), face, *mesh);
          region = neighbors->flood(*mesh, face, angle, &selectable, &open, &cancel);
        }
        return Found{mesh, FaceBits(mesh->faceCount(), region)};
      });
  edit.act = [this, adding](const Found& found) { return takeFound(adding, "", found); };
  return {};
}

/// The label's faces, or those of them that are seen.
void SelectionEditor::putLabel(Edit& edit, const Event& event, const SurfaceHit& hit, bool adding,
                               LabelFacesConstPtr faces, const SelectionSettings& settings)
{
  FaceSearch view = searchInView(hit, event, settings);
  if (!view.choosesBySight()) {
    put(edit, hit.mesh, adding, std::move(faces));
    return;
  }
  edit.found = queue_.ask([view = std::move(view), faces = std::move(faces),
                           face = hit.face](const std::atomic<bool>& cancel) {
    const MeshDataConstPtr& mesh = view.shown.mesh;
    return Found{mesh, withFace(view.chosenOf(*faces, &cancel), face, *mesh)};
  });
  edit.act = [this, adding](const Found& found) { return takeFound(adding, "", found); };
}

std::string SelectionEditor::area(const Event& event, const Gesture& gesture,
                                  const std::vector<Pixel>& path, const SelectionSettings& settings)
{
  Edit edit;
  edit.begin = [this, view = std::make_shared<const FrozenView>(event), gesture, path,
                settings](Edit& begun) {
    return beginArea(begun, view->event(), gesture, path, settings);
  };
  return queue_.perform(std::move(edit));
}

std::string SelectionEditor::beginArea(Edit& edit, const Event& event, const Gesture& gesture,
                                       const std::vector<Pixel>& path,
                                       const SelectionSettings& settings)
{
  const MeshDataConstPtr mesh = session_.selection().empty() ? nullptr : session_.mesh();
  SearchTarget target = gesture.adding ? areaTarget(picker_, mesh, path, event, settings)
                                       : selectedTarget(picker_, mesh, event, settings);
  if (target.searches.empty()) {
    return target.reason;
  }
  const auto points = pointsOf(path, *event.viewport);
  for (FaceSearch& search : target.searches) {
    const auto to_clip = meshToClip(*event.viewport->getCamera(), search.shown);
    if (gesture.kind == Gesture::LASSO) {
      search.regions.push_back(std::make_shared<mesh_map::LassoRegion>(points, to_clip));
    } else {
      search.regions.push_back(std::make_shared<mesh_map::ConvexRegion>(
          boxRegion(points.front(), points.back(), to_clip)));
    }
  }
  return search(edit, std::move(target.searches), gesture.adding,
                target.reason.empty() ? NOTHING_THERE : target.reason);
}

/// The mesh that has the selection once the edits that wait have been made, as far as they know.
MeshDataConstPtr SelectionEditor::comingMesh() const
{
  const MeshDataConstPtr coming = queue_.comingMesh();
  return coming ? coming : session_.mesh();
}

SelectableFaces SelectionEditor::selectableOf(const MeshDataConstPtr& mesh) const
{
  ShownMesh as_shown;
  as_shown.mesh = mesh;
  for (const ShownMesh& shown : picker_.meshes()) {
    if (shown.mesh == mesh) {
      as_shown = shown;
      break;
    }
  }
  return SelectableFaces(as_shown);
}

std::optional<ShownMesh> SelectionEditor::shownMesh() const
{
  const MeshDataConstPtr wanted = comingMesh();
  for (const ShownMesh& shown : picker_.meshes()) {
    if (!wanted || shown.mesh == wanted) {
      return shown;
    }
  }
  return std::nullopt;
}

/// What is in the first of these regions where there is anything; few are found at once.
std::string SelectionEditor::search(Edit& edit, std::vector<FaceSearch> searches, bool adding,
                                    const std::string& nothing)
{
  std::size_t most = 0;
  for (const FaceSearch& search : searches) {
    most += std::min(search.most(), MANY_FACES + 1);
  }
  edit.mesh = adding && searches.size() == 1 ? searches.front().shown.mesh : nullptr;
  if (most > MANY_FACES) {
    edit.found = queue_.ask([searches = std::move(searches)](const std::atomic<bool>& cancel) {
      return find(searches, cancel);
    });
    edit.act = [this, adding, nothing](const Found& found) {
      return takeFound(adding, nothing, found);
    };
    return {};
  }
  for (const FaceSearch& search : searches) {
    FaceSelection::Faces faces = search();
    if (!faces.empty()) {
      put(edit, search.shown.mesh, adding,
          std::make_shared<const FaceSelection::Faces>(std::move(faces)));
      return {};
    }
  }
  edit.act = [nothing](const Found& /*found*/) { return nothing; };
  return {};
}

SelectionEditor::Found SelectionEditor::find(const std::vector<FaceSearch>& searches,
                                             const std::atomic<bool>& cancel)
{
  for (const FaceSearch& search : searches) {
    FaceBits faces = search.bits(&cancel);
    if (faces.count() > 0) {
      return Found{search.shown.mesh, std::move(faces)};
    }
  }
  return Found();
}

/// Selects or deselects these; many, of a label, are made bits of on the thread.
void SelectionEditor::put(Edit& edit, const MeshDataConstPtr& mesh, bool adding,
                          LabelFacesConstPtr faces)
{
  if (faces->size() > MANY_FACES) {
    edit.found = queue_.ask([mesh, faces = std::move(faces),
                             selectable = selectableOf(mesh)](const std::atomic<bool>& cancel) {
      Found found{mesh, FaceBits(mesh->faceCount(), *faces)};
      selectable.keep(found.faces, &cancel);
      return found;
    });
    edit.act = [this, adding](const Found& found) { return takeFound(adding, "", found); };
    return;
  }
  edit.act = [this, mesh, adding, faces = std::move(faces)](const Found& /*found*/) {
    FaceSelection::Faces seen = *faces;
    selectableOf(mesh).keep(seen);
    return apply(mesh, adding, [&](FaceSelection& selection) -> const FaceSelection::Change& {
      return adding ? selection.select(seen) : selection.deselect(seen);
    });
  };
}

std::string SelectionEditor::takeFound(bool adding, const std::string& nothing, const Found& found)
{
  if (!found.mesh) {
    return nothing;
  }
  return apply(found.mesh, adding, [&](FaceSelection& selection) -> const FaceSelection::Change& {
    const HiddenFacesConstPtr hidden = adding ? hiddenFaces(*found.mesh) : nullptr;
    if (!hidden) {
      return adding ? selection.selectBits(found.faces) : selection.deselectBits(found.faces);
    }
    FaceBits seen = found.faces;  // some may have been hidden while they were looked for
    seen.remove(hidden->bits());
    return selection.selectBits(seen);
  });
}

std::string SelectionEditor::apply(const MeshDataConstPtr& mesh, bool adding, const Make& make)
{
  std::string text;
  if (!picker_.exists(mesh)) {
    return "the mesh is gone of which faces were looked for";
  }
  if (mesh != session_.mesh()) {
    if (!adding) {
      return NONE_SELECTED;
    }
    if (const std::size_t lost = session_.selection().count()) {
      text = "this is another mesh: " + std::to_string(lost) +
             " faces of the one before are not selected any more";
    }
    const bool in_stroke = session_.selection().inStroke();
    session_.setMesh(mesh);
    if (in_stroke) {
      session_.beginStroke();
    }
  }
  session_.change(make);
  return text;
}

void SelectionEditor::beginStroke()
{
  stroke_ = std::make_shared<BrushStroke>();
  brush_.reset();
  Edit edit;
  edit.tells = false;
  edit.act = [this](const Found& /*found*/) {
    session_.beginStroke();
    return std::string();
  };
  queue_.perform(std::move(edit));
}

void SelectionEditor::endStroke()
{
  if (!std::exchange(stroke_, nullptr)) {
    return;
  }
  Edit edit;
  edit.tells = false;
  edit.act = [this](const Found& /*found*/) {
    session_.endStroke();
    return std::string();
  };
  queue_.perform(std::move(edit));
}

void SelectionEditor::findBrush(const Event& event, const SelectionSettings& settings)
{
  brush_ = picker_.pick(event, settings.back_faces).hit;
}

std::string SelectionEditor::stroke(const Event& event, const Gesture& gesture,
                                    const SelectionSettings& settings)
{
  if (!stroke_) {
    return {};
  }
  BrushMove move{std::make_shared<const FrozenView>(event), gesture, settings};
  Edit* const last = queue_.last();
  std::string text;
  if (!last || !last->brush || !last->brush->add(stroke_, move)) {
    Edit edit;
    edit.brush = std::make_shared<BrushMoves>(stroke_, std::move(move));
    edit.begin = [this, adding = gesture.adding](Edit& begun) { return beginMoves(begun, adding); };
    text = queue_.perform(std::move(edit));
  }
  brush_ = busy() ? picker_.pick(event, settings.back_faces).hit : stroke_->last();
  return text;
}

std::string SelectionEditor::beginMoves(Edit& edit, bool adding)
{
  edit.later = !edit.brush->follow(picker_, session_.mesh());
  if (edit.later) {
    return {};
  }
  const auto brush = std::exchange(edit.brush, nullptr);
  if (brush->search().regions.empty()) {
    return brush->reason();
  }
  return search(edit, {std::move(brush->search())}, adding, "");
}

std::string SelectionEditor::change(const Make& make)
{
  Edit edit;
  edit.act = [this, make](const Found& /*found*/) -> std::string {
    if (!session_.mesh()) {
      return NO_MESH;
    }
    session_.change(make);
    return {};
  };
  return queue_.perform(std::move(edit));
}

std::string SelectionEditor::selectAll()
{
  return changeSelectable(&FaceSelection::selectAll, &FaceSelection::replaceBits, true);
}

std::string SelectionEditor::invert()
{
  return changeSelectable(&FaceSelection::invert, &FaceSelection::toggleBits, false);
}

/// Where all faces can be selected, that takes no time.
std::string SelectionEditor::changeSelectable(const Make& all, const ChangeAmong& among,
                                              bool of_first_mesh)
{
  Edit edit;
  edit.begin = [this, all, among, of_first_mesh](Edit& begun) -> std::string {
    if (!session_.mesh() && of_first_mesh) {  // nor have the edits before it found any
      const auto shown = picker_.meshes();
      session_.setMesh(shown.empty() ? nullptr : shown.front().mesh);
    }
    if (!session_.mesh()) {
      return NO_MESH;
    }
    const SelectableFaces selectable = selectableOf(session_.mesh());
    if (selectable.all()) {
      session_.change(all);
    } else {
      begun.found =
          queue_.ask([mesh = session_.mesh(), selectable](const std::atomic<bool>& cancel) {
            return Found{mesh, selectable.bits(&cancel)};
          });
    }
    return {};
  };
  edit.act = [this, among](const Found& found) {
    return !found.mesh ? std::string()
                       : apply(found.mesh, true, [&](FaceSelection& selection) -> decltype(auto) {
                           return among(selection, found.faces);
                         });
  };
  return queue_.perform(std::move(edit));
}

std::string SelectionEditor::replace(const MeshDataConstPtr& mesh,
                                     const std::vector<LabelFacesConstPtr>& faces)
{
  if (!mesh || !picker_.exists(mesh)) {
    return GONE;
  }
  giveUp();
  session_.setMesh(mesh);
  std::size_t count = 0;
  for (const LabelFacesConstPtr& some : faces) {
    count += some->size();
  }
  const auto bits = [mesh, faces] {
    FaceBits all(mesh->faceCount());
    for (const LabelFacesConstPtr& some : faces) {
      all.add(*some);
    }
    return all;
  };
  Edit edit;
  edit.mesh = mesh;
  if (count > MANY_FACES) {
    edit.found = queue_.ask([mesh, bits](const std::atomic<bool>& /*cancel*/) {
      return Found{mesh, bits()};
    });
  }
  edit.act = [this, mesh, bits](const Found& found) {
    return apply(mesh, true, [&](FaceSelection& selection) -> const FaceSelection::Change& {
      return selection.replaceBits(found.mesh ? found.faces : bits());
    });
  };
  return queue_.perform(std::move(edit));
}

std::string SelectionEditor::combine(const MeshDataConstPtr& mesh, Combination how,
                                     const FindFaces& find)
{
  const bool adding = how == Combination::ADD || how == Combination::REPLACE;
  if (!mesh || !picker_.exists(mesh)) {
    return GONE;
  }
  Edit edit;
  edit.mesh = adding ? mesh : nullptr;
  edit.begin = [this, mesh, adding, find](Edit& begun) -> std::string {
    if (!adding && mesh != session_.mesh()) {
      return NONE_SELECTED;
    }
    begun.found =
        queue_.ask([mesh, find, selectable = selectableOf(mesh)](const std::atomic<bool>& cancel) {
          Found found{mesh, find(cancel)};
          selectable.keep(found.faces, &cancel);
          return found;
        });
    return {};
  };
  edit.act = [this, adding, how](const Found& found) {
    const std::string text =
        apply(found.mesh, adding, [&](FaceSelection& selection) -> const FaceSelection::Change& {
          return selection.combineBits(found.faces, how);
        });
    return text.empty() && found.faces.count() == 0 ? NO_SUCH_FACES : text;
  };
  return queue_.perform(std::move(edit));
}

/// @param others false: the selected ones
std::string SelectionEditor::hide(bool others)
{
  Edit edit;
  edit.begin = [this, others](Edit& begun) -> std::string {
    if (session_.selection().empty()) {
      return others ? "select faces first, to see them alone" : "select faces first, to hide them";
    }
    const MeshDataConstPtr& mesh = session_.mesh();
    begun.found =
        queue_.ask([mesh, others, before = hiddenFaces(*mesh),
                    selected = session_.selection().bits()](const std::atomic<bool>& /*cancel*/) {
          return Found{mesh, FaceBits(), FaceHiding::with(selected, others, before)};
        });
    return {};
  };
  edit.act = [this](const Found& found) {
    return found.mesh == session_.mesh() ? hiding_->hide(found.hidden, session_)
                                         : "the mesh is gone of which faces were to be hidden";
  };
  return queue_.perform(std::move(edit));
}

std::string SelectionEditor::showAll()
{
  Edit edit;
  edit.act = [this](const Found& /*found*/) { return hiding_->showAll(); };
  return queue_.perform(std::move(edit));
}

std::size_t SelectionEditor::hiddenCount() const
{
  return hiding_->count();
}

std::string SelectionEditor::step(bool undo)
{
  Edit edit;
  edit.act = [this, undo](const Found& /*found*/) { return histories_.step(undo, session_); };
  return queue_.perform(std::move(edit));
}

std::shared_ptr<const FaceNeighbors> SelectionEditor::neighborsOf(const MeshDataConstPtr& mesh,
                                                                  std::string& failure)
{
  const auto state = SurfaceIndex::instance().findNeighbors(mesh);
  if (!state.failure.empty()) {
    failure = "which faces lie beside each other cannot be told: " + state.failure;
  }
  return state.neighbors;
}

std::string SelectionEditor::growOrShrink(bool grow)
{
  Edit edit;
  edit.begin = [this, grow](Edit& begun) -> std::string {
    const MeshDataConstPtr& mesh = session_.mesh();
    const FaceSelection& selection = session_.selection();
    if (!mesh || selection.empty()) {
      return "nothing is selected that could grow or shrink";
    }
    std::string reason;
    const auto neighbors = neighborsOf(mesh, reason);
    begun.later = !neighbors && reason.empty();
    const auto ring = [grow, neighbors, mesh, selected = selection.bits(),
                       selectable = selectableOf(mesh)](const std::atomic<bool>& cancel) {
      auto faces = grow ? neighbors->grow(selected, &cancel) : neighbors->shrink(selected, &cancel);
      selectable.keep(faces, &cancel);
      return Found{mesh, FaceBits(mesh->faceCount(), faces)};
    };
    if (neighbors && selection.count() > MANY_FACES) {
      begun.found = queue_.ask(ring);
    } else if (neighbors) {
      reason = takeFound(grow, "", ring(std::atomic<bool>(false)));
    }
    return reason;
  };
  edit.act = [this, grow](const Found& found) { return takeFound(grow, "", found); };
  return queue_.perform(std::move(edit));
}

bool SelectionEditor::giveUp()
{
  const bool searching = queue_.giveUp();
  const bool stroking = std::exchange(stroke_, nullptr) != nullptr;
  if (session_.selection().inStroke()) {
    session_.change(&FaceSelection::giveUpStroke);
  }
  return searching || stroking;
}

void SelectionEditor::prepare(const SelectionSettings& settings)
{
  const auto meshes = picker_.meshes();
  if (meshes.size() == 1 && !session_.mesh() && !session_.awaited() && !stroke_ && !busy()) {
    session_.setMesh(meshes.front().mesh);  // its vertices are uploaded then
  }
  for (const ShownMesh& shown : meshes) {
    if (settings.technique == SelectionTechnique::FLOOD) {
      SurfaceIndex::instance().findNeighbors(shown.mesh);
    }
  }
}

SelectionEditor::FrameResult SelectionEditor::dropLostMesh()
{
  const auto is_gone = [this](const MeshDataConstPtr& mesh) {
    return mesh && !picker_.exists(mesh);
  };
  FrameResult result;
  if (stroke_ && is_gone(stroke_->mesh())) {
    giveUp();
    result = {"the mesh is gone that the brush was on", true};
  }
  if (brush_ && is_gone(brush_->mesh)) {
    brush_.reset();
  }
  if (is_gone(session_.mesh())) {
    const std::size_t lost = session_.selection().count();
    giveUp();
    session_.setAside();
    result.mesh_gone = true;
    if (lost > 0) {
      result.text = "the mesh is gone of which " + std::to_string(lost) + " faces were selected";
    }
  }
  return result;
}

/// Displays that were reset, or whose time has jumped back, get it again.
std::string SelectionEditor::takeReturnedMesh()
{
  if (!session_.awaited()) {
    return {};
  }
  const SurfacePicker::Search found = picker_.search(session_.awaited()->uuid);
  const auto same = std::find_if(found.meshes.begin(), found.meshes.end(),
                                 [&](const auto& mesh) { return session_.isAwaited(*mesh); });
  if (same == found.meshes.end()) {
    if (!found.meshes.empty() || !found.others_expected) {
      session_.forgetAwaited();
    }
    return {};
  }
  session_.setMesh(*same);
  const std::size_t count = session_.selection().count();
  return count == 0 ? std::string()
                    : "the mesh is there again: " + std::to_string(count) +
                          " faces are selected as before";
}

SelectionEditor::FrameResult SelectionEditor::frame()
{
  FrameResult result = dropLostMesh();
  const std::string returned = takeReturnedMesh();
  if (!returned.empty()) {
    result.text = returned;
  }
  const std::optional<std::string> text = queue_.advance();
  if (text && (!text->empty() || !result.text)) {
    result.text = text;
  }
  session_.follow(picker_.meshes());
  return result;
}

}  // namespace rviz_mesh_plugin
