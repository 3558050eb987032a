#include "label_editing/label_history.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "base/erase_if.h"

namespace rviz_mesh_plugin {
namespace {

bool isSame(const LabelFacesConstPtr& now, const LabelFacesConstPtr& expected,
            const FaceParentsConstPtr& parents)
{
  return now == expected || *now == *expected ||
         (parents && *now == wholeFaces(*expected, *parents));
}

std::size_t bytesOf(const std::deque<LabelStep>& steps)
{
  std::size_t bytes = 0;
  for (const LabelStep& step : steps) {
    bytes += step.bytes();
  }
  return bytes;
}

}  // namespace

std::size_t LabelStep::bytes() const
{
  std::size_t bytes = sizeof(LabelStep);
  for (const LabelChange& change : changes) {
    bytes += sizeof(LabelChange) +
             sizeof(std::uint32_t) * (change.before.faces->size() + change.after.faces->size());
  }
  return bytes;
}

LabelStep stepOf(const std::string& what, std::uint64_t order, const std::vector<LabelEdit>& edits,
                 const std::function<LabelState(const std::string& label)>& state)
{
  LabelStep step;
  step.order = order;
  step.mesh = edits.front().mesh;
  step.what = what;
  for (const LabelEdit& edit : edits) {
    auto change = std::find_if(step.changes.begin(), step.changes.end(),
                               [&](const auto& known) { return known.label == edit.label; });
    if (change == step.changes.end()) {
      const LabelState now = state(edit.label);
      change = step.changes.insert(change, {edit.label, now, now});
    }
    if (!edit.faces) {
      change->after.color = edit.color;
    } else {
      change->after.faces = edit.adds ? edit.whole : edit.faces;
    }
    if (change->after.faces->empty()) {
      change->after.color.reset();  // which goes with the label
    }
  }
  return step;
}

std::vector<LabelEdit> editsBack(const LabelStep& step, bool undo, const std::vector<LabelNow>& now,
                                 const FaceParentsConstPtr& parents)
{
  std::vector<LabelEdit> edits;
  std::string gets_faces;  // the first label that does: others go after it
  for (std::size_t i = 0; i < step.changes.size(); ++i) {
    const LabelChange& change = step.changes[i];
    const LabelState& expected = undo ? change.after : change.before;
    const LabelState& wanted = undo ? change.before : change.after;
    const LabelState& is = now.at(i).state;
    // What is not touched may be known late, as colors are.
    const bool of_color = change.before.color != change.after.color || wanted.faces->empty();
    if (!isSame(is.faces, expected.faces, parents) || (of_color && is.color != expected.color)) {
      throw std::runtime_error(step.what + (undo ? " cannot be undone" : " cannot be done again") +
                               ": '" + change.label +
                               "' has been changed elsewhere since, and that would be lost; this "
                               "step is forgotten");
    }
    LabelEdit edit;
    edit.mesh = step.mesh;
    edit.label = change.label;
    if (wanted.faces != expected.faces && *wanted.faces != *expected.faces) {
      LabelEdit faces = edit;
      faces.faces = wanted.faces;
      // What is on its way may have been sent, or not.
      faces.based_on = {is.faces, now[i].stored};
      if (gets_faces.empty() && !wanted.faces->empty()) {
        gets_faces = change.label;
      }
      edits.push_back(std::move(faces));
    }
    // A label that goes takes its color along.
    const bool had_color = !expected.faces->empty() && expected.color;
    const bool is_same = had_color ? wanted.color == expected.color : !wanted.color;
    if (!wanted.faces->empty() && !is_same) {
      edit.color = wanted.color;
      edits.push_back(std::move(edit));
    }
  }
  for (LabelEdit& edit : edits) {
    if (edit.faces && edit.faces->empty() && edit.label != gets_faces) {
      edit.after = gets_faces;
    }
  }
  return edits;
}

std::uint64_t LabelHistory::orderOf(const Steps& steps, const MeshId& mesh)
{
  const auto newest = std::find_if(steps.rbegin(), steps.rend(),
                                   [&](const LabelStep& step) { return step.mesh == mesh; });
  return newest == steps.rend() ? 0 : newest->order;
}

LabelStep LabelHistory::take(Steps& steps, const MeshId& mesh)
{
  const auto newest = std::find_if(steps.rbegin(), steps.rend(),
                                   [&](const LabelStep& step) { return step.mesh == mesh; });
  if (newest == steps.rend()) {
    throw std::logic_error("no step of this mesh");
  }
  LabelStep step = std::move(*newest);
  steps.erase(std::next(newest).base());
  return step;
}

void LabelHistory::put(Steps& steps, LabelStep step)
{
  eraseIf(meshes_, [&](const MeshId& mesh) {
    return mesh == step.mesh || (orderOf(done_, mesh) == 0 && orderOf(undone_, mesh) == 0);
  });
  meshes_.push_back(step.mesh);
  if (meshes_.size() > MESHES) {
    const auto is_of_oldest = [&](const LabelStep& one) { return one.mesh == meshes_.front(); };
    eraseIf(done_, is_of_oldest);
    eraseIf(undone_, is_of_oldest);
    meshes_.pop_front();
  }
  steps.push_back(std::move(step));
  std::size_t bytes = bytesOf(done_) + bytesOf(undone_);
  while (bytes > bytes_ && !done_.empty()) {
    bytes -= done_.front().bytes();
    done_.pop_front();
  }
}

void LabelHistory::forgetUndoneBefore(const MeshId& mesh, std::uint64_t order)
{
  eraseIf(undone_, [&](const LabelStep& step) { return step.mesh == mesh && step.order < order; });
}

}  // namespace rviz_mesh_plugin
