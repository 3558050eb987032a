#include "tools/selection/selection_editor.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <utility>

#include <OgreViewport.h>
#include <rviz/display_context.h>

#include "base/vectors.h"
#include "picking/label_lookup.h"
#include "picking/surface_index.h"
#include "selection/face_neighbors.h"

namespace rviz_mesh_plugin {
namespace {

constexpr const char* NOTHING_THERE = "there are no faces to be selected there";
constexpr const char* NONE_SELECTED = "nothing is selected there that could be deselected";

/// Between two events, the brush is set down so often at most.
constexpr std::size_t MAX_SAMPLES = 256;

/// How far the brush moves before it is set down again, in radii.
constexpr double STEP = 0.5;

/// Beside the surface, it is looked for every so many pixels.
constexpr int MISSES = 8;

struct BrushPath
{
  std::vector<SurfaceHit> hits;
  std::optional<SurfaceHit> last;  ///< under the cursor; none where no surface is there
};

struct Sample
{
  Pixel at;
  std::optional<SurfaceHit> hit;
};

bool areClose(const Sample& a, const Sample& b, double radius, const Ogre::Viewport& viewport)
{
  const int way = std::max(std::abs(a.at.x - b.at.x), std::abs(a.at.y - b.at.y));
  if (way <= 1 || (!a.hit && !b.hit && way <= MISSES)) {
    return true;
  }
  if (!a.hit || !b.hit || a.hit->mesh != b.hit->mesh) {
    return false;
  }
  const double step = STEP * radius;
  return distance(a.hit->point, b.hit->point) <= step &&
         way <= pixelsOf(step, std::max(a.hit->distance, b.hit->distance), viewport);
}

/// Where the brush touches surfaces on the way of the cursor from one event to the next: so often
/// that it leaves no gaps, on the surface and in the picture.
/// @param before what was under the cursor at the beginning, which is not among the hits
BrushPath followBrush(const SurfacePicker& picker, const rviz::ViewportMouseEvent& event,
                      const Gesture& gesture, std::optional<SurfaceHit> before,
                      const SelectionSettings& settings)
{
  rviz::ViewportMouseEvent between = event;
  const auto sampleAt = [&](const Pixel& at) {
    between.x = at.x;
    between.y = at.y;
    return Sample{at, picker.pick(between, settings.back_faces).hit};
  };
  Sample last{gesture.from, std::move(before)};
  std::vector<Sample> ahead{sampleAt(gesture.to)};  // the next one last
  BrushPath path;
  path.last = ahead.front().hit;
  for (std::size_t samples = 1; !ahead.empty();) {
    const Pixel next = ahead.back().at;
    if (samples < MAX_SAMPLES && !areClose(last, ahead.back(), settings.radius, *event.viewport)) {
      ahead.push_back(sampleAt({(last.at.x + next.x) / 2, (last.at.y + next.y) / 2}));
      ++samples;
      continue;
    }
    last = std::move(ahead.back());
    ahead.pop_back();
    if (last.hit) {
      path.hits.push_back(*last.hit);
    }
  }
  return path;
}

}  // namespace

SelectionEditor::SelectionEditor(rviz::DisplayContext* context, const SurfacePicker& picker,
                                 const std::function<void()>& on_change)
    : context_(context), picker_(picker), session_(context->getSceneManager(), on_change)
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
    ask(hit.mesh, adding,
        [neighbors = std::move(neighbors), mesh = hit.mesh, face = hit.face,
         angle = settings.flood_angle](const std::atomic<bool>& cancel) {
          return neighbors->flood(*mesh, face, angle, &cancel);
        });
  }
  return reason;
}

std::string SelectionEditor::area(const Event& event, const Gesture& gesture,
                                  const std::vector<Pixel>& path, const SelectionSettings& settings)
{
  Target target = findTarget(event, gesture, path, settings);
  if (!target.reason.empty()) {
    return target.reason;
  }
  const auto points = pointsOf(path, *event.viewport);
  const auto to_clip = meshToClip(*event.viewport->getCamera(), target.search.shown);
  const bool lasso = gesture.kind == Gesture::LASSO;
  auto& regions = target.search.regions;
  if (lasso) {
    regions.push_back(std::make_shared<mesh_map::LassoRegion>(points, to_clip));
  } else {
    regions.push_back(std::make_shared<mesh_map::ConvexRegion>(
        boxRegion(points.front(), points.back(), to_clip)));
  }
  return search(std::move(target.search), gesture.adding, lasso || settings.visible_only);
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
                                                    const std::vector<Pixel>& path,
                                                    const SelectionSettings& settings) const
{
  if (!gesture.adding) {
    return selectedTarget(event, settings);
  }
  const auto [lower, upper] = boundsOf(path);
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
  ask(mesh, adding,
      [search = std::move(search)](const std::atomic<bool>& cancel) { return search(&cancel); });
  return {};
}

/// @param work owns what it uses, and gives up soon after the flag is set
/// @throw std::system_error where no thread can be started, std::bad_alloc
void SelectionEditor::ask(const MeshDataConstPtr& mesh, bool adding,
                          std::function<FaceSelection::Faces(const std::atomic<bool>&)> work)
{
  using Task = std::packaged_task<FaceSelection::Faces(const std::atomic<bool>&)>;
  const auto task = std::make_shared<Task>(std::move(work));
  thread_.add([task](const Cancellation& cancellation) { (*task)(cancellation.flag()); });
  questions_.push_back({mesh, adding, task->get_future()});
}

/// Of the first question.
std::string SelectionEditor::takeAnswer()
{
  Question answered = std::move(questions_.front());
  questions_.pop_front();
  FaceSelection::Faces faces;
  try {
    faces = answered.faces.get();
  } catch (const std::exception& error) {
    return std::string("faces could not be found: ") + error.what();
  }
  return picker_.exists(answered.mesh) ? apply(answered.mesh, answered.adding, faces)
                                       : "the mesh is gone of which faces were looked for";
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
  return change(&FaceSelection::selectAll);
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
  thread_.cancel();
  const bool searching = !std::exchange(questions_, {}).empty();
  const bool stroking = std::exchange(stroking_, false);
  stroke_ending_ = false;
  stroke_mesh_.reset();
  if (stroking && session_.selection().inStroke()) {
    session_.change(&FaceSelection::giveUpStroke);
  }
  return searching || stroking;
}

void SelectionEditor::prepare(const SelectionSettings& settings)
{
  const auto meshes = picker_.meshes();
  if (meshes.size() == 1 && !session_.mesh() && !session_.awaited() && !stroking_) {
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
  if (is_gone(stroke_mesh_)) {
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
  result.text = returned.empty() ? result.text : returned;
  while (busy() &&
         questions_.front().faces.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const std::string text = takeAnswer();
    result.text = text.empty() ? result.text : text;
  }
  finishStroke();
  session_.follow(picker_.meshes());
  return result;
}

}  // namespace rviz_mesh_plugin
