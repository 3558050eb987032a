#include "tools/selection/face_hiding.h"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "base/erase_if.h"
#include "base/status_lines.h"
#include "picking/surface_picker.h"
#include "tools/selection/selection_session.h"

namespace rviz_mesh_plugin {

HiddenFacesConstPtr FaceHiding::with(const FaceBits& faces, bool others,
                                     const HiddenFacesConstPtr& before)
{
  FaceBits hidden = faces;
  if (others) {
    hidden.addAll();
    hidden.remove(faces);
  }
  if (before) {
    hidden.unite(before->bits());
  }
  return std::make_shared<const HiddenFaces>(std::move(hidden));
}

std::string FaceHiding::hide(const HiddenFacesConstPtr& hidden, SelectionSession& session)
{
  const MeshData& mesh = *session.mesh();
  const HiddenFacesConstPtr before = hiddenFaces(mesh);
  if (hidden->count() == (before ? before->count() : 0)) {
    return "all other faces are hidden already";
  }
  const std::uint64_t order = nextStepOrder();
  perform({order, {{mesh, before, hidden}}});
  session.change([&](FaceSelection& selection) -> const FaceSelection::Change& {
    const FaceSelection::Change& change = selection.deselectBits(hidden->bits());
    if (!change.empty()) {
      selection.joinStep(order);
    }
    return change;
  });
  return joined(hidden->count(), " of ", counted(mesh.faceCount(), "face is", "faces are"),
                " hidden: Ctrl+H shows them again");
}

std::string FaceHiding::showAll()
{
  Step step{nextStepOrder(), {}};
  for (const ShownMesh& shown : meshes()) {
    step.changes.push_back({*shown.mesh, shown.hidden, nullptr});
  }
  if (step.changes.empty()) {
    return "no face is hidden";
  }
  const std::size_t shown_again = count();
  perform(std::move(step));
  return counted(shown_again, "face is", "faces are") + " shown again";
}

std::size_t FaceHiding::count() const
{
  std::size_t count = 0;
  for (const ShownMesh& shown : meshes()) {
    count += shown.hidden->count();
  }
  return count;
}

/// Those that are shown with hidden faces, each once.
std::vector<ShownMesh> FaceHiding::meshes() const
{
  std::vector<ShownMesh> meshes;
  for (const ShownMesh& shown : picker_.meshes()) {
    const bool is_known = std::any_of(meshes.begin(), meshes.end(), [&](const ShownMesh& other) {
      return MeshKey(*other.mesh) == MeshKey(*shown.mesh);
    });
    if (shown.hidden && !is_known) {
      meshes.push_back(shown);
    }
  }
  return meshes;
}

void FaceHiding::perform(Step step)
{
  for (const Change& change : step.changes) {
    setHiddenFaces(change.mesh, change.after);
  }
  undone_.clear();
  done_.push_back(std::move(step));
  while (bytes() > bytes_ && done_.size() > 1) {
    done_.pop_front();
  }
}

std::string FaceHiding::move(std::deque<Step>& from, std::deque<Step>& to, bool undo)
{
  if (from.empty()) {
    return {};
  }
  Step step = std::move(from.back());
  from.pop_back();
  bool is_seen = false;
  const auto meshes = picker_.meshes();
  for (const Change& change : step.changes) {
    if (hiddenFaces(change.mesh) != (undo ? change.after : change.before)) {
      return "something else has been hidden or shown since, with another tool: this step is "
             "forgotten";
    }
    is_seen = is_seen || std::any_of(meshes.begin(), meshes.end(), [&](const ShownMesh& shown) {
                return MeshKey(*shown.mesh) == change.mesh;
              });
  }
  for (const Change& change : step.changes) {
    setHiddenFaces(change.mesh, undo ? change.before : change.after);
  }
  to.push_back(std::move(step));
  return is_seen ? "" : "faces of a mesh that is not shown now are hidden or shown again";
}

void FaceHiding::forgetUndoneBefore(std::uint64_t order)
{
  eraseIf(undone_, [&](const Step& step) { return step.order < order; });
}

/// Of all steps; what one hides is mostly what the next one finds hidden.
std::size_t FaceHiding::bytes() const
{
  std::set<const HiddenFaces*> all;
  for (const std::deque<Step>* steps : {&done_, &undone_}) {
    for (const Step& step : *steps) {
      for (const Change& change : step.changes) {
        all.insert({change.before.get(), change.after.get()});
      }
    }
  }
  all.erase(nullptr);
  std::size_t bytes = 0;
  for (const HiddenFaces* hidden : all) {
    bytes += hidden->mask().size() + hidden->bits().wordCount() * sizeof(FaceBits::Word);
  }
  return bytes;
}

}  // namespace rviz_mesh_plugin
