#include "tools/selection/selection_query.h"

#include <deque>
#include <exception>
#include <mutex>
#include <utility>

namespace rviz_mesh_plugin {

/// Shared with the thread; another one after giveUp().
struct SelectionQuery::Answers
{
  std::mutex mutex;
  std::deque<Answer> ready;
};

SelectionQuery::~SelectionQuery()
{
  giveUp();
}

void SelectionQuery::ask(const MeshDataConstPtr& mesh, bool adding, Work work)
{
  if (!answers_) {
    answers_ = std::make_shared<Answers>();
  }
  thread_.add(
      [answers = answers_, mesh, adding, work = std::move(work)](const Cancellation& cancellation) {
        Answer answer{mesh, adding, {}, {}};
        try {
          answer.faces = work(cancellation.flag());
        } catch (const std::exception& error) {
          answer.failure = error.what();
        }
        try {
          const std::lock_guard<std::mutex> lock(answers->mutex);
          answers->ready.push_back(std::move(answer));
        } catch (const std::exception&) {  // no memory: the user may give it up
        }
      });
  ++open_;
}

std::optional<SelectionQuery::Answer> SelectionQuery::take()
{
  if (!answers_) {
    return std::nullopt;
  }
  const std::lock_guard<std::mutex> lock(answers_->mutex);
  if (answers_->ready.empty()) {
    return std::nullopt;
  }
  std::optional<Answer> answer(std::move(answers_->ready.front()));
  answers_->ready.pop_front();
  --open_;
  return answer;
}

bool SelectionQuery::giveUp()
{
  thread_.cancel();
  answers_.reset();
  return std::exchange(open_, 0) != 0;
}

}  // namespace rviz_mesh_plugin
