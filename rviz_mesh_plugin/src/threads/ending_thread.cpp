#include "threads/ending_thread.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>
#include <vector>

namespace rviz_mesh_plugin {

struct EndingThread::Running
{
  std::shared_ptr<std::atomic<bool>> ended = std::make_shared<std::atomic<bool>>(false);
  std::thread thread;

  /// Waits for at most as long as a thread that has ended takes to be gone.
  bool joinIfEnded()
  {
    if (*ended) {
      thread.join();
    }
    return !thread.joinable();
  }
};

namespace {

/// Threads whose owners are gone.
template <class Running>
class Leftovers
{
 public:
  ~Leftovers()
  {
    for (auto& running : running_) {
      running->thread.join();
    }
  }

  void add(std::unique_ptr<Running> running)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    running_.erase(std::remove_if(running_.begin(), running_.end(),
                                  [](auto& other) { return other->joinIfEnded(); }),
                   running_.end());
    if (!running->joinIfEnded()) {
      running_.push_back(std::move(running));
    }
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Running>> running_;
};

}  // namespace

EndingThread::EndingThread(std::function<void()> work) : running_(std::make_unique<Running>())
{
  running_->thread = std::thread([ended = running_->ended, work = std::move(work)]() mutable {
    work();
    work = nullptr;  // what it owns is freed before it counts as ended
    *ended = true;
  });
}

EndingThread::~EndingThread()
{
  static Leftovers<Running> leftovers;
  leftovers.add(std::move(running_));
}

}  // namespace rviz_mesh_plugin
