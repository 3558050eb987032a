#include "label_editing/pending_edits.h"

#include <algorithm>
#include <utility>

namespace rviz_mesh_plugin {

bool LabelEdit::hasChanged(const LabelFacesConstPtr& now) const
{
  const auto isOneOf = [&](const std::vector<LabelFacesConstPtr>& expected) {
    return std::any_of(expected.begin(), expected.end(),
                       [&](const LabelFacesConstPtr& one) { return one == now || *one == *now; });
  };
  return !based_on.empty() && !isOneOf(based_on) && !isOneOf(overtaken);
}

void PendingEdits::add(LabelEdit edit)
{
  const Key key{edit.mesh, edit.label, edit.faces == nullptr};
  Pending pending;
  pending.edit = std::move(edit);
  Pending& before = edits_[key];
  if (pending.edit.faces && before.edit.faces) {
    pending.edit.overtaken = std::move(before.edit.overtaken);
    if (before.sent) {  // and comes back, maybe, before this one is sent
      pending.edit.overtaken.push_back(before.edit.adds ? before.edit.whole : before.edit.faces);
    }
  }
  before = std::move(pending);
  const LabelEdit& added = before.edit;
  if (added.faces && added.faces->empty() && !added.adds) {
    edits_.erase({added.mesh, added.label, true});  // which goes with the label
  }
  breakCircle(added);
}

/// Labels that got each other's faces in turn would wait for each other for ever. The one that is
/// to have the faces goes first.
void PendingEdits::breakCircle(const LabelEdit& edit)
{
  std::vector<LabelEdit*> waiting;
  std::string label = edit.label;
  do {
    const auto next = edits_.find({edit.mesh, label, false});
    if (next == edits_.end() || next->second.edit.after.empty()) {
      return;
    }
    waiting.push_back(&next->second.edit);
    label = next->second.edit.after;
  } while (label != edit.label);
  const auto first = std::find_if(waiting.begin(), waiting.end(),
                                  [](const LabelEdit* one) { return !one->faces->empty(); });
  (first == waiting.end() ? waiting.front() : *first)->after.clear();
}

bool PendingEdits::mustWait(const LabelEdit& edit) const
{
  if (!edit.faces && edits_.count({edit.mesh, edit.label, false}) != 0) {
    return true;  // there may be no label to color yet
  }
  return !edit.after.empty() && isPending(edit.mesh, edit.after);
}

std::vector<LabelEdit> PendingEdits::work(Clock::time_point now,
                                          const std::function<bool(const LabelEdit&)>& is_stored,
                                          const std::function<std::string(const LabelEdit&)>& send,
                                          const std::function<void(const LabelEdit&)>& ask)
{
  std::vector<LabelEdit> stored;
  std::size_t under_way = 0;
  for (auto entry = edits_.begin(); entry != edits_.end();) {
    Pending& pending = entry->second;
    if (pending.sent && is_stored(pending.edit)) {
      stored.push_back(std::move(pending.edit));
      entry = edits_.erase(entry);
      continue;
    }
    if (pending.sent && pending.failure.empty()) {
      if (!pending.asked && now - pending.since > patience_ / 2) {
        pending.asked = true;
        ask(pending.edit);
      }
      if (now - pending.since > patience_) {
        pending.failure =
            "it was sent, but has not come back as stored: see the log of the node "
            "that stores labels";
      } else {
        ++under_way;
      }
    }
    ++entry;
  }
  for (auto& entry : edits_) {
    Pending& pending = entry.second;
    if (under_way == AT_ONCE) {
      break;
    }
    if (!pending.sent && pending.failure.empty() && !mustWait(pending.edit)) {
      pending.failure = send(pending.edit);
      pending.sent = pending.failure.empty();
      pending.since = now;
      pending.asked = false;
      under_way += pending.sent ? 1 : 0;
    }
  }
  return stored;
}

void PendingEdits::sendAgain()
{
  for (auto& entry : edits_) {
    if (!entry.second.failure.empty()) {
      entry.second.failure.clear();
      entry.second.sent = false;
    }
  }
}

std::size_t PendingEdits::failed() const
{
  return static_cast<std::size_t>(
      std::count_if(edits_.begin(), edits_.end(),
                    [](const auto& entry) { return !entry.second.failure.empty(); }));
}

std::string PendingEdits::failure() const
{
  for (const auto& entry : edits_) {
    if (!entry.second.failure.empty()) {
      return (entry.second.edit.faces ? "label '" : "the color of '") + entry.second.edit.label +
             "' is not stored: " + entry.second.failure;
    }
  }
  return {};
}

OptionalStatus PendingEdits::status() const
{
  const std::string failure = this->failure();
  if (!failure.empty()) {
    return StatusLine::warn(failure);
  }
  if (edits_.empty()) {
    return std::nullopt;
  }
  return StatusLine::ok("'", edits_.begin()->second.edit.label, "' is being stored");
}

bool PendingEdits::isPending(const MeshId& mesh, const std::string& label) const
{
  return edits_.count({mesh, label, false}) != 0 || edits_.count({mesh, label, true}) != 0;
}

bool PendingEdits::isSent(const MeshId& mesh, const std::string& label) const
{
  return std::any_of(edits_.begin(), edits_.end(), [&](const auto& pending) {
    const LabelEdit& edit = pending.second.edit;
    return pending.second.sent && edit.mesh == mesh && edit.label == label;
  });
}

const LabelEdit* PendingEdits::find(const MeshId& mesh, const std::string& label) const
{
  const auto found = edits_.find({mesh, label, false});
  return found == edits_.end() ? nullptr : &found->second.edit;
}

const LabelEdit* PendingEdits::findColor(const MeshId& mesh, const std::string& label) const
{
  const auto found = edits_.find({mesh, label, true});
  return found == edits_.end() ? nullptr : &found->second.edit;
}

std::vector<std::string> PendingEdits::labels(const MeshId& mesh) const
{
  std::vector<std::string> labels;
  for (const auto& entry : edits_) {
    const LabelEdit& edit = entry.second.edit;
    if (edit.mesh == mesh && edit.faces && !edit.faces->empty()) {
      labels.push_back(edit.label);
    }
  }
  return labels;
}

}  // namespace rviz_mesh_plugin
