#include "rviz_mesh_plugin/mesh_loader.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <new>
#include <utility>

#include "rviz_mesh_plugin/ending_thread.h"
#include "rviz_mesh_plugin/mesh_conversion.h"
#include "rviz_mesh_plugin/mesh_registry.h"

namespace rviz_mesh_plugin {
namespace {

/// Messages of more meshes than this do not wait: the oldest is refused.
constexpr std::size_t MOST_WAITING = 16;

/// A message to convert, or a mesh to lay out.
struct Job
{
  std::string uuid;
  mesh_msgs::MeshGeometryStamped::ConstPtr message;
  MeshDataConstPtr mesh;
  Split split = Split::NONE;
  MaterialsConstPtr materials;

  bool isSameLayout(const Job& other) const
  {
    return mesh == other.mesh && split == other.split && materials == other.materials;
  }
};

/// How a mesh was asked to be laid out last.
struct Wish
{
  std::weak_ptr<const MeshData> mesh;
  Split split = Split::NONE;
  std::weak_ptr<const Materials> materials;
};

std::string describe(const Job& job)
{
  const std::size_t faces =
      job.message ? job.message->mesh_geometry.faces.size() : job.mesh->faceCount();
  return std::to_string(faces) + " faces of mesh '" + job.uuid + "'";
}

template <class Entries, class Predicate>
void eraseIf(Entries& entries, const Predicate& predicate)
{
  entries.erase(std::remove_if(entries.begin(), entries.end(), predicate), entries.end());
}

template <class Predicate>
void moveIf(std::deque<Job>& from, std::vector<Job>& to, const Predicate& predicate)
{
  const auto moved = std::stable_partition(from.begin(), from.end(), std::not_fn(predicate));
  std::move(moved, from.end(), std::back_inserter(to));
  from.erase(moved, from.end());
}

}  // namespace

/// Shared by the loader and its thread, which may outlive it.
class MeshLoader::Worker
{
 public:
  explicit Worker(bool with_layouts) : with_layouts_(with_layouts) {}

  void receive(const mesh_msgs::MeshGeometryStamped::ConstPtr& message)
  {
    std::vector<Job> dropped;  // freed without the lock, which takes long
    const std::lock_guard<std::mutex> lock(mutex_);
    moveIf(waiting_, dropped,
           [&](const Job& job) { return job.message && job.uuid == message->uuid; });
    const auto is_message = [](const Job& job) { return job.message != nullptr; };
    if (static_cast<std::size_t>(std::count_if(waiting_.begin(), waiting_.end(), is_message)) >=
        MOST_WAITING) {
      const auto oldest = std::find_if(waiting_.begin(), waiting_.end(), is_message);
      refuse("mesh '" + oldest->uuid + "' was dropped, because " + std::to_string(MOST_WAITING) +
             " more arrived before it could be shown; publish them more slowly");
      dropped.push_back(std::move(*oldest));
      waiting_.erase(oldest);
    }
    Job job;
    job.uuid = message->uuid;
    job.message = message;
    waiting_.push_back(std::move(job));
    // Never twice in a row: else a fast publisher would not be shown at all.
    if (laying_out_ && current_.uuid == message->uuid && !gave_up_) {
      cancelled_ = gave_up_ = true;
    }
    wake_.notify_one();
  }

  void layOut(const MeshDataConstPtr& mesh, Split split, const MaterialsConstPtr& materials)
  {
    Job job;
    job.uuid = mesh->uuid;
    job.mesh = mesh;
    job.split = split;
    job.materials = split == Split::BY_MATERIAL ? materials : nullptr;
    const std::lock_guard<std::mutex> lock(mutex_);
    eraseIf(waiting_, [&](const Job& other) { return other.mesh && other.uuid == job.uuid; });
    for (auto wish = wishes_.begin(); wish != wishes_.end();) {
      wish = wish->second.mesh.expired() ? wishes_.erase(wish) : std::next(wish);
    }
    wishes_[job.uuid] = {mesh, split, job.materials};
    if (laying_out_ && current_.mesh == mesh && !cancelled_) {
      if (current_.isSameLayout(job)) {
        return;
      }
      cancelled_ = true;
    }
    waiting_.push_back(std::move(job));
    wake_.notify_one();
  }

  Content take()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Content content = std::move(ready_);
    ready_ = Content();
    ready_.reception = content.reception;
    content.working = working_;
    return content;
  }

  void clear()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.clear();
    wishes_.clear();
    ready_ = Content();
    working_.clear();
    cancelled_ = true;
    gave_up_ = false;
    ++generation_;
  }

  void stop()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopped_ = cancelled_ = true;
    waiting_.clear();
    wake_.notify_one();
  }

  void run()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      wake_.wait(lock, [this]() { return stopped_ || !waiting_.empty(); });
      if (stopped_) {
        return;
      }
      current_ = std::move(waiting_.front());
      waiting_.pop_front();
      cancelled_ = false;
      current_generation_ = generation_;
      work(lock);
      laying_out_ = false;
      working_.clear();
      Job done = std::move(current_);
      current_ = Job();
      lock.unlock();
      done = Job();  // freed without the lock, which takes long
      lock.lock();
    }
  }

 private:
  /// With the lock, which is given up for as long as work is done.
  void work(std::unique_lock<std::mutex>& lock)
  {
    std::string failure;
    try {
      if (!current_.message || load(lock)) {
        layOutCurrent(lock);
      }
      return;
    } catch (const RejectedMessage& rejected) {
      failure = rejected.what();
    } catch (const std::bad_alloc&) {
      failure = "there is not enough memory; close programs, or make the mesh smaller";
    } catch (const std::exception& error) {
      failure = error.what();
    }
    lockAgain(lock);
    if (isWanted()) {
      refuse(failure);
    }
  }

  static void lockAgain(std::unique_lock<std::mutex>& lock)
  {
    if (!lock.owns_lock()) {
      lock.lock();
    }
  }

  /// False where there is nothing to lay out.
  bool load(std::unique_lock<std::mutex>& lock)
  {
    working_ = "converting " + describe(current_);
    auto message = std::move(current_.message);
    current_.message = nullptr;
    lock.unlock();
    const MeshDataConstPtr mesh = internMesh(convert(*message));
    message = nullptr;
    lock.lock();
    if (!isWanted()) {
      return false;
    }
    ++ready_.reception.accepted;
    ready_.reception.refusal.clear();
    eraseIf(ready_.meshes, [&](const auto& other) { return other->uuid == mesh->uuid; });
    eraseIf(ready_.layouts, [&](const auto& other) {
      return other->mesh->uuid == mesh->uuid && other->mesh != mesh;
    });
    eraseIf(waiting_,
            [&](const Job& job) { return job.mesh && job.uuid == mesh->uuid && job.mesh != mesh; });
    ready_.meshes.push_back(mesh);
    current_.mesh = mesh;
    const auto wish = wishes_.find(mesh->uuid);
    if (wish != wishes_.end() && wish->second.mesh.lock() == mesh) {
      current_.split = wish->second.split;
      current_.materials = wish->second.materials.lock();
      if (current_.split == Split::BY_MATERIAL && !current_.materials) {
        current_.split = Split::NONE;
      }
    }
    return with_layouts_;
  }

  void layOutCurrent(std::unique_lock<std::mutex>& lock)
  {
    const Job job = current_;
    laying_out_ = true;
    working_ = "laying out " + describe(job);
    lock.unlock();
    MeshLayoutConstPtr layout = findLayout(job.mesh, job.split, job.materials);
    if (!layout) {
      if (job.split == Split::NONE && job.mesh->faceCount() > PREVIEW_FACES && !cancelled_) {
        const MeshLayoutConstPtr preview = layOutPreview(job.mesh);
        lock.lock();
        deliver(preview);
        lock.unlock();
      }
      layout = cancelled_
                   ? nullptr
                   : rviz_mesh_plugin::layOut(job.mesh, job.split, job.materials, cancelled_);
      if (layout) {
        rememberLayout(layout);
      }
    }
    lock.lock();
    deliver(layout);
    gave_up_ = gave_up_ && layout == nullptr;
  }

  /// Unless it is null, or an old one that nobody wants any more.
  void deliver(const MeshLayoutConstPtr& layout)
  {
    if (!layout || !isWanted()) {
      return;
    }
    eraseIf(ready_.layouts,
            [&](const auto& other) { return other->mesh->uuid == layout->mesh->uuid; });
    ready_.layouts.push_back(layout);
  }

  bool isWanted() const { return !stopped_ && current_generation_ == generation_; }

  void refuse(const std::string& reason)
  {
    ++ready_.reception.refused;
    ready_.reception.refusal = reason;
  }

  const bool with_layouts_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Job> waiting_;
  std::map<std::string, Wish> wishes_;  ///< by uuid
  Content ready_;
  std::string working_;
  Job current_;
  bool laying_out_ = false;
  bool gave_up_ = false;  ///< the layout before this one, for a newer message
  bool stopped_ = false;
  std::uint64_t generation_ = 0;  ///< counts calls of clear()
  std::uint64_t current_generation_ = 0;
  std::atomic<bool> cancelled_{false};
};

MeshLoader::MeshLoader(bool with_layouts)
    : worker_(std::make_shared<Worker>(with_layouts)),
      thread_(std::make_unique<EndingThread>([worker = worker_]() { worker->run(); }))
{
}

MeshLoader::~MeshLoader()
{
  worker_->stop();
}

void MeshLoader::receive(const mesh_msgs::MeshGeometryStamped::ConstPtr& message)
{
  worker_->receive(message);
}

void MeshLoader::layOut(const MeshDataConstPtr& mesh, Split split,
                        const MaterialsConstPtr& materials)
{
  worker_->layOut(mesh, split, materials);
}

MeshLoader::Content MeshLoader::take()
{
  return worker_->take();
}

void MeshLoader::clear()
{
  worker_->clear();
}

}  // namespace rviz_mesh_plugin
