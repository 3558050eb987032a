#include "threads/work_thread.h"

#include <pthread.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <future>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace rviz_mesh_plugin {

/// What a thread and its owner share.
struct WorkThread::Queue
{
  Cancellation cancellation;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Task> tasks;

  void add(Task task)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    tasks.push_back(std::move(task));
    changed.notify_all();
  }

  void close()
  {
    std::deque<Task> dropped;  // destroyed after the lock
    const std::lock_guard<std::mutex> lock(mutex);
    cancellation.set();
    tasks.swap(dropped);
    changed.notify_all();
  }

  /// The thread.
  void work()
  {
    std::unique_lock<std::mutex> lock(mutex);
    while (true) {
      changed.wait(lock, [this] { return cancellation.flag() || !tasks.empty(); });
      if (cancellation.flag()) {
        return;
      }
      Task task = std::move(tasks.front());
      tasks.pop_front();
      lock.unlock();
      task(cancellation);
      task = nullptr;
      lock.lock();
    }
  }
};

/// All threads that have not been joined.
class WorkThread::Running
{
 public:
  /// Made with the first thread, and so destroyed after what threads made later.
  static Running& instance()
  {
    static Running running;
    return running;
  }

  ~Running()
  {
    for (const One& one : all_) {
      if (const auto queue = one.queue.lock()) {
        queue->close();
      }
    }
    for (One& one : all_) {
      if (!one.patience || one.ended.wait_for(*one.patience) == std::future_status::ready) {
        one.thread.join();
      } else {
        one.thread.detach();
      }
    }
  }

  void start(const std::shared_ptr<Queue>& queue, const std::string& name,
             const std::optional<std::chrono::milliseconds>& patience)
  {
    std::packaged_task<void()> work([owned = queue, name]() mutable {
      pthread_setname_np(pthread_self(), name.c_str());
      owned->work();
      owned.reset();  // before it counts as ended
    });
    const std::lock_guard<std::mutex> lock(mutex_);
    joinEnded();
    all_.emplace_back();
    try {
      One& one = all_.back();
      one.queue = queue;
      one.patience = patience;
      one.ended = work.get_future();
      one.thread = std::thread(std::move(work));
    } catch (...) {
      all_.pop_back();
      throw;
    }
  }

 private:
  struct One
  {
    std::weak_ptr<Queue> queue;
    std::optional<std::chrono::milliseconds> patience;
    std::future<void> ended;
    std::thread thread;
  };

  /// Waits for at most as long as a thread that has ended takes to be gone.
  void joinEnded()
  {
    const auto ended = std::partition(all_.begin(), all_.end(), [](const One& one) {
      return one.ended.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
    });
    std::for_each(ended, all_.end(), [](One& one) { one.thread.join(); });
    all_.erase(ended, all_.end());
  }

  std::mutex mutex_;
  std::vector<One> all_;
};

WorkThread::WorkThread(std::string name, std::optional<std::chrono::milliseconds> patience)
    : name_(std::move(name)), patience_(patience)
{
}

WorkThread::~WorkThread()
{
  cancel();
}

void WorkThread::add(Task task)
{
  if (!queue_) {
    auto queue = std::make_shared<Queue>();
    Running::instance().start(queue, name_, patience_);
    queue_ = std::move(queue);
  }
  queue_->add(std::move(task));
}

void WorkThread::cancel()
{
  if (queue_) {
    queue_->close();
    queue_.reset();
  }
}

}  // namespace rviz_mesh_plugin
