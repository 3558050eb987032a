#include "label_editing/edit_command_queue.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "rendering/labels/label_parts.h"

namespace rviz_mesh_plugin {

std::string EditCommandQueue::perform(EditCommand command)
{
  if (isBusy(command.mesh)) {
    commands_.push_back(std::move(command));
    return {};
  }
  return begin(std::move(command));
}

/// With its turn. Returns why it cannot be done.
std::string EditCommandQueue::begin(EditCommand command)
{
  try {
    EditPlan plan = user_.begin(command);
    if (!plan.reason.empty()) {
      return plan.reason;
    }
    if (plan.faces <= MANY_FACES) {
      return user_.finish(command, plan.make());
    }
    making_.start(
        [make = std::move(plan.make)](const Cancellation& /*cancellation*/) { return make(); });
  } catch (const std::exception& error) {
    return error.what();
  }
  commands_.push_front(std::move(command));
  return {};
}

std::optional<std::string> EditCommandQueue::work()
{
  std::optional<std::string> reason;
  if (const auto made = making_.take()) {
    const EditCommand command = std::move(commands_.front());
    commands_.pop_front();
    reason = made->result ? user_.finish(command, *made->result) : made->error;
  }
  while (!making_.isRunning()) {
    const auto next =
        std::find_if(commands_.begin(), commands_.end(),
                     [this](const EditCommand& command) { return user_.is_shown(command.mesh); });
    if (next == commands_.end()) {
      break;
    }
    EditCommand command = std::move(*next);
    commands_.erase(next);
    const std::string failure = begin(std::move(command));
    reason = reason && failure.empty() ? reason : failure;
  }
  return reason;
}

void EditCommandQueue::giveUp()
{
  commands_.clear();
  making_.drop();
}

bool EditCommandQueue::isBusy(const MeshId& mesh) const
{
  return making_.isRunning() ||
         std::any_of(commands_.begin(), commands_.end(),
                     [&](const EditCommand& command) { return command.mesh == mesh; });
}

std::vector<const EditCommand*> EditCommandQueue::held() const
{
  std::vector<const EditCommand*> held;
  for (const EditCommand& command : commands_) {
    const bool has_begun = making_.isRunning() && &command == &commands_.front();
    if (!has_begun && !user_.is_shown(command.mesh)) {
      held.push_back(&command);
    }
  }
  return held;
}

}  // namespace rviz_mesh_plugin
