#include "base/step_history.h"

#include <algorithm>

#include "base/erase_if.h"

namespace rviz_mesh_plugin {

void StepHistories::add(const std::shared_ptr<StepHistory>& history)
{
  eraseIf(others_, [&](const auto& other) {
    const auto known = other.lock();
    return !known || known == history;
  });
  others_.push_back(history);
}

std::string StepHistories::step(bool undo, StepHistory& own)
{
  std::vector<std::shared_ptr<StepHistory>> kept;
  std::vector<StepHistory*> all{&own};
  for (const auto& other : others_) {
    if (auto history = other.lock()) {
      all.push_back(history.get());
      kept.push_back(std::move(history));
    }
  }
  std::uint64_t newest = 0;
  for (const StepHistory* history : all) {
    const std::string reason = history->whyNotNow();
    if (!reason.empty()) {
      return reason;
    }
    newest = std::max(newest, history->undoOrder());
  }
  std::uint64_t next = undo ? newest : 0;
  for (StepHistory* history : all) {
    history->forgetUndoneBefore(newest);
    const std::uint64_t order = undo ? 0 : history->redoOrder();
    next = order != 0 && (next == 0 || order < next) ? order : next;
  }
  if (next == 0) {
    return undo ? "there is nothing to undo" : "there is nothing to redo";
  }
  std::string text;
  for (StepHistory* history : all) {
    if (next == (undo ? history->undoOrder() : history->redoOrder())) {
      const std::string told = undo ? history->undo() : history->redo();
      text = told.empty() ? text : told;
    }
  }
  return text;
}

}  // namespace rviz_mesh_plugin
