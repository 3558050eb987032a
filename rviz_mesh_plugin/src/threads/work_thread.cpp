#include "threads/work_thread.h"

#include <pthread.h>

#include <algorithm>
#include <condition_variable>
#include <cstdlib>
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
  std::thread::id worker;  ///< while it works
  bool working = true;

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

  void waitForEnd()
  {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait(lock, [this] { return !working || worker == std::this_thread::get_id(); });
  }

  /// The thread.
  void work()
  {
    std::unique_lock<std::mutex> lock(mutex);
    worker = std::this_thread::get_id();
    while (true) {
      changed.wait(lock, [this] { return cancellation.flag() || !tasks.empty(); });
      if (cancellation.flag()) {
        working = false;
        changed.notify_all();
        return;
      }
      Task task = std::move(tasks.front());
      tasks.pop_front();
      lock.unlock();
      try {
        task(cancellation);
      } catch (...) {
        // Only where there was no memory to keep an error in: those that follow are done all the
        // same.
      }
      task = nullptr;
      lock.lock();
    }
  }
};

/// All threads that have not been joined.
class WorkThread::Running
{
 public:
  /// Never destroyed: threads may start others while the process ends.
  static Running& instance()
  {
    static Running& running = [&]() -> Running& {
      std::atexit(&WorkThread::joinAll);
      return *new Running;
    }();
    return running;
  }

  void joinAll()
  {
    for (std::vector<One> all = takeAll(); !all.empty(); all = takeAll()) {
      for (const One& one : all) {
        if (const auto queue = one.queue.lock()) {
          queue->close();
        }
      }
      for (One& one : all) {
        if (!one.patience || one.ended.wait_for(*one.patience) == std::future_status::ready) {
          one.thread.join();
        } else {
          one.thread.detach();
        }
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

  std::vector<One> takeAll()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(all_, {});
  }

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

void WorkThread::joinAll()
{
  Running::instance().joinAll();
}

void WorkThread::join()
{
  const std::shared_ptr<Queue> queue = queue_;
  cancel();
  if (queue) {
    queue->waitForEnd();
  }
}

void WorkThread::cancel()
{
  if (queue_) {
    queue_->close();
    queue_.reset();
  }
}

}  // namespace rviz_mesh_plugin
