#include "threads/work_lanes.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace rviz_mesh_plugin {
namespace {

/// What a lane and its thread share.
struct Queue
{
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<WorkLanes::Task> tasks;
  bool closed = false;
  bool ended = false;
};

void work(const std::shared_ptr<Queue>& queue)
{
  std::unique_lock<std::mutex> lock(queue->mutex);
  while (true) {
    queue->changed.wait(lock, [&]() { return queue->closed || !queue->tasks.empty(); });
    if (queue->closed) {
      break;
    }
    WorkLanes::Task task = std::move(queue->tasks.front());
    queue->tasks.pop_front();
    lock.unlock();
    task();
    task = nullptr;
    lock.lock();
  }
  queue->ended = true;
  queue->changed.notify_all();
}

}  // namespace

class WorkLanes::Lane
{
 public:
  Lane() : queue_(std::make_shared<Queue>()), thread_(work, queue_) {}

  ~Lane()
  {
    if (thread_.joinable()) {
      thread_.detach();
    }
  }

  void add(Task task)
  {
    const std::lock_guard<std::mutex> lock(queue_->mutex);
    queue_->tasks.push_back(std::move(task));
    queue_->changed.notify_all();
  }

  void close()
  {
    std::deque<Task> dropped;  // destroyed after the lock
    const std::lock_guard<std::mutex> lock(queue_->mutex);
    queue_->closed = true;
    queue_->tasks.swap(dropped);
    queue_->changed.notify_all();
  }

  /// Joins the thread, if it ends until then.
  bool join(std::chrono::steady_clock::time_point end)
  {
    {
      std::unique_lock<std::mutex> lock(queue_->mutex);
      if (!queue_->changed.wait_until(lock, end, [this]() { return queue_->ended; })) {
        return false;
      }
    }
    thread_.join();
    return true;
  }

 private:
  std::shared_ptr<Queue> queue_;
  std::thread thread_;
};

/// Closed lanes whose threads may still run.
class WorkLanes::Leftovers
{
 public:
  /// The one of this process; a thread that outlived it would run code that is gone.
  static Leftovers& instance()
  {
    static Leftovers leftovers;
    return leftovers;
  }

  ~Leftovers()
  {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    for (const auto& lane : lanes_) {
      lane->join(end);
    }
  }

  void add(std::unique_ptr<Lane> lane)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    lanes_.push_back(std::move(lane));
    lanes_.erase(std::remove_if(lanes_.begin(), lanes_.end(),
                                [now](const auto& one) { return one->join(now); }),
                 lanes_.end());
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Lane>> lanes_;
};

WorkLanes::WorkLanes() = default;

WorkLanes::~WorkLanes()
{
  for (auto& lane : lanes_) {
    lane.second->close();
    Leftovers::instance().add(std::move(lane.second));
  }
}

void WorkLanes::add(const std::string& lane, Task task)
{
  auto place = lanes_.find(lane);
  if (place == lanes_.end()) {
    Leftovers::instance();  // made before the thread is, and so destroyed later
    auto made = std::make_unique<Lane>();
    place = lanes_.emplace(lane, std::move(made)).first;
  }
  place->second->add(std::move(task));
}

}  // namespace rviz_mesh_plugin
