#include "tools/selection/edit_queue.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

namespace rviz_mesh_plugin {
namespace {

/// So long edits are made in one frame that have their faces, but one at least.
constexpr std::chrono::milliseconds EDITS_BUDGET{15};

}  // namespace

std::string EditQueue::perform(Edit edit)
{
  edits_.push_back(std::move(edit));
  const bool at_once = edits_.size() == 1 && !edits_.front().found.valid();
  return at_once ? advance().value_or(std::string()) : std::string();
}

std::optional<std::string> EditQueue::advance()
{
  const auto end = std::chrono::steady_clock::now() + EDITS_BUDGET;
  std::optional<std::string> last;
  while (!edits_.empty()) {
    Edit& first = edits_.front();
    std::string text;
    auto begin = std::exchange(first.begin, nullptr);
    if (begin) {
      first.later = false;
      text = begin(first);
      if (first.later) {
        first.begin = std::move(begin);
        break;
      }
    }
    if (text.empty() && first.found.valid() &&
        (begin || first.found.wait_for(std::chrono::seconds(0)) != std::future_status::ready)) {
      break;
    }
    Edit edit = std::move(first);
    edits_.pop_front();
    if (text.empty()) {
      Found found;
      try {
        found = edit.found.valid() ? edit.found.get() : Found();
      } catch (const std::exception& error) {
        text = std::string("faces could not be found: ") + error.what();
      }
      text = text.empty() ? edit.act(std::move(found)) : text;
    }
    if (edit.tells) {
      last = text;
    }
    if (std::chrono::steady_clock::now() >= end) {
      break;
    }
  }
  return last;
}

std::future<EditQueue::Found> EditQueue::ask(std::function<Found(const std::atomic<bool>&)> work)
{
  using Task = std::packaged_task<Found(const std::atomic<bool>&)>;
  const auto task = std::make_shared<Task>(std::move(work));
  thread_.add([task](const Cancellation& cancellation) { (*task)(cancellation.flag()); });
  return task->get_future();
}

MeshDataConstPtr EditQueue::comingMesh() const
{
  const auto last = std::find_if(edits_.rbegin(), edits_.rend(),
                                 [](const Edit& edit) { return edit.mesh != nullptr; });
  return last == edits_.rend() ? nullptr : last->mesh;
}

bool EditQueue::giveUp()
{
  thread_.cancel();
  return !std::exchange(edits_, {}).empty();
}

}  // namespace rviz_mesh_plugin
