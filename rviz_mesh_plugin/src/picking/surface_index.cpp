#include "picking/surface_index.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <new>
#include <utility>
#include <vector>

#include <mesh_map/bvh/tree/bvh.h>
#include <ros/console.h>

#include "base/vectors.h"
#include "selection/face_neighbors.h"
#include "threads/cancellation.h"

namespace rviz_mesh_plugin {
namespace {

/// How often is looked for meshes that are gone, in between.
constexpr std::chrono::milliseconds LOOK_EVERY(500);

using WeakMesh = std::weak_ptr<const MeshData>;

void logLine(LogLevel level, const std::string& line)
{
  if (level == LogLevel::WARNING) {
    ROS_WARN("%s", line.c_str());
  } else {
    ROS_INFO("%s", line.c_str());
  }
}

}  // namespace

/// Shared by the index and its thread, which may outlive it.
class SurfaceIndex::Worker
{
 public:
  explicit Worker(SpatialQueriesOptions options) : options_(std::move(options)) {}

  State find(const MeshDataConstPtr& mesh)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Entry& entry = ask(mesh, &Entry::asked, &Worker::makeQueries);
    return entry.state;
  }

  NeighborState findNeighbors(const MeshDataConstPtr& mesh)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Entry& entry = ask(mesh, &Entry::asked_neighbors, &Worker::makeNeighbors);
    return entry.neighbors;
  }

  std::size_t meshCount() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return static_cast<std::size_t>(std::count_if(
        entries_.begin(), entries_.end(), [](const auto& it) { return !it.first.expired(); }));
  }

  std::size_t givenUp() const { return given_up_; }

  void stop()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    canceled_ = true;
    wake_.notify_one();
  }

  /// The thread.
  void run(const Cancellation& cancellation)
  {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!cancellation.flag()) {
      dropGone(lock);
      if (jobs_.empty()) {
        wake_.wait_for(lock, LOOK_EVERY);
        continue;
      }
      if (cancellation.flag()) {  // while that was freed
        return;
      }
      Job job = std::move(jobs_.front());
      jobs_.pop_front();
      canceled_ = false;
      lock.unlock();
      work(job);
      lock.lock();
    }
  }

 private:
  struct Entry
  {
    bool asked = false;
    bool asked_neighbors = false;
    State state;
    NeighborState neighbors;
  };
  struct Job
  {
    WeakMesh mesh;
    void (Worker::*make)(const WeakMesh&) = nullptr;
  };

  Entry& ask(const MeshDataConstPtr& mesh, bool Entry::*asked,
             void (Worker::*make)(const WeakMesh&))
  {
    Entry& entry = entries_[mesh];
    if (!(entry.*asked)) {
      jobs_.push_back({mesh, make});
      entry.*asked = true;
      wake_.notify_one();
    }
    return entry;
  }

  /// What they had is freed without the lock, which may take long.
  void dropGone(std::unique_lock<std::mutex>& lock)
  {
    std::vector<Entry> gone;
    for (auto it = entries_.begin(); it != entries_.end();) {
      if (it->first.expired()) {
        gone.push_back(std::move(it->second));
        it = entries_.erase(it);
      } else {
        ++it;
      }
    }
    if (!gone.empty()) {
      lock.unlock();
      gone.clear();
      lock.lock();
    }
  }

  void work(const Job& job)
  {
    std::string failure;
    try {
      (this->*job.make)(job.mesh);
      return;
    } catch (const Canceled&) {
      ++given_up_;
      return;
    } catch (const std::bad_alloc&) {
      failure = "there is not enough memory to prepare it: show a smaller mesh, or close others";
    } catch (const std::exception& error) {
      failure = error.what();
    }
    const auto entry = locked(job.mesh);
    if (entry.second && job.make == &Worker::makeQueries) {
      entry.second->state.failure = failure;
    } else if (entry.second) {
      entry.second->neighbors.failure = failure;
    }
  }

  /// With the lock; null where there is none.
  std::pair<std::unique_lock<std::mutex>, Entry*> locked(const WeakMesh& mesh)
  {
    std::unique_lock<std::mutex> lock(mutex_);
    const auto found = entries_.find(mesh);
    return {std::move(lock), found == entries_.end() ? nullptr : &found->second};
  }

  static MeshDataConstPtr alive(const WeakMesh& mesh)
  {
    const MeshDataConstPtr data = mesh.lock();
    if (!data) {
      throw Canceled();
    }
    return data;
  }

  void makeQueries(const WeakMesh& mesh)
  {
    MeshDataConstPtr data = alive(mesh);
    const std::vector<float> positions = positionsOf(*data);
    const std::vector<std::uint32_t> faces = data->indices;
    data.reset();  // so that it can go meanwhile
    mesh_map::BvhOptions run;
    run.cancel = &canceled_;
    run.progress = [&](double fraction) {
      if (mesh.expired()) {
        canceled_ = true;
      } else if (const auto entry = locked(mesh); entry.second) {
        entry.second->state.progress = static_cast<float>(fraction);
      }
    };
    auto bvh = std::make_shared<const mesh_map::Bvh>(mesh_map::Bvh::build({positions, faces}, run));
    auto queries = std::make_shared<const SpatialQueries>(std::move(bvh), options_);
    if (const auto entry = locked(mesh); entry.second) {
      entry.second->state.queries.swap(queries);
      entry.second->state.progress = 1.0f;
    }
  }

  void makeNeighbors(const WeakMesh& mesh)
  {
    const auto corners = joinedCorners(*alive(mesh));
    auto neighbors = std::make_shared<const FaceNeighbors>(corners, &canceled_);
    if (const auto entry = locked(mesh); entry.second) {
      entry.second->neighbors.neighbors.swap(neighbors);
    }
  }

  const SpatialQueriesOptions options_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::map<WeakMesh, Entry, std::owner_less<>> entries_;
  std::deque<Job> jobs_;
  std::atomic<bool> canceled_{false};  ///< the job
  std::atomic<std::size_t> given_up_{0};
};

SurfaceIndex& SurfaceIndex::instance()
{
  static SurfaceIndex& index = *[] {
    SpatialQueriesOptions options;
    options.log = logLine;
    return new SurfaceIndex(options);
  }();
  return index;
}

SurfaceIndex::SurfaceIndex(SpatialQueriesOptions options) : options_(std::move(options)) {}

SurfaceIndex::~SurfaceIndex()
{
  clear();
}

void SurfaceIndex::clear()
{
  std::shared_ptr<Worker> worker;
  const std::lock_guard<std::mutex> lock(mutex_);
  worker.swap(worker_);
  thread_.cancel();
  if (worker) {
    worker->stop();
  }
}

std::shared_ptr<void> SurfaceIndex::user()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  std::shared_ptr<void> user = user_.lock();
  if (!user) {
    user.reset(this, [](SurfaceIndex* index) { index->clear(); });
    user_ = user;
  }
  return user;
}

/// With its thread.
std::shared_ptr<SurfaceIndex::Worker> SurfaceIndex::worker()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!worker_) {
    auto worker = std::make_shared<Worker>(options_);
    thread_.add([worker](const Cancellation& cancellation) { worker->run(cancellation); });
    worker_ = std::move(worker);
  }
  return worker_;
}

SurfaceIndex::State SurfaceIndex::find(const MeshDataConstPtr& mesh)
{
  return worker()->find(mesh);
}

SurfaceIndex::NeighborState SurfaceIndex::findNeighbors(const MeshDataConstPtr& mesh)
{
  return worker()->findNeighbors(mesh);
}

std::size_t SurfaceIndex::meshCount() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return worker_ ? worker_->meshCount() : 0;
}

std::size_t SurfaceIndex::givenUp() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return worker_ ? worker_->givenUp() : 0;
}

}  // namespace rviz_mesh_plugin
