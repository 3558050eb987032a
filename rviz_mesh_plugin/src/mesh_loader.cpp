#include "rviz_mesh_plugin/mesh_loader.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <new>
#include <utility>

#include "rviz_mesh_plugin/ending_thread.h"
#include "rviz_mesh_plugin/mesh_conversion.h"
#include "rviz_mesh_plugin/mesh_jobs.h"
#include "rviz_mesh_plugin/mesh_registry.h"

namespace rviz_mesh_plugin {
namespace {

template <class Entries, class Predicate>
void eraseIf(Entries& entries, const Predicate& predicate)
{
  entries.erase(std::remove_if(entries.begin(), entries.end(), predicate), entries.end());
}

}  // namespace

/// Shared by the loader and its thread, which may outlive it.
class MeshLoader::Worker
{
 public:
  explicit Worker(bool with_layouts) : with_layouts_(with_layouts) {}

  void receive(const mesh_msgs::MeshGeometryStamped::ConstPtr& message, const Flag* dropped)
  {
    std::vector<MeshJob> removed;  // freed without the lock, which takes long
    const std::lock_guard<std::mutex> lock(mutex_);
    if (dropped != nullptr && *dropped) {
      return;
    }
    const std::string refusal = jobs_.add(message, removed);
    if (!refusal.empty()) {
      ready_.reception.refuse(refusal);
    }
    // Never twice in a row: else a fast publisher would not be shown at all.
    if (laying_out_ && current_.uuid == message->uuid && !gave_up_) {
      cancelled_ = gave_up_ = true;
    }
    wake_.notify_one();
  }

  void refuse(const std::string& reason, const Flag* dropped)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (dropped == nullptr || !*dropped) {
      ready_.reception.refuse(reason);
    }
  }

  void layOut(const MeshDataConstPtr& mesh, Split split, const MaterialsConstPtr& materials)
  {
    MeshJob job;
    job.uuid = mesh->uuid;
    job.mesh = mesh;
    job.split = split;
    job.materials = split == Split::BY_MATERIAL ? materials : nullptr;
    const std::lock_guard<std::mutex> lock(mutex_);
    jobs_.setWish(job);
    if (laying_out_ && current_.mesh == mesh && !cancelled_) {
      if (current_.isSameLayout(job)) {
        return;
      }
      cancelled_ = true;
    }
    jobs_.add(std::move(job));
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
    jobs_.clear();
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
    jobs_.clear();
    wake_.notify_one();
  }

  void run()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      wake_.wait(lock, [this]() { return stopped_ || !jobs_.empty(); });
      if (stopped_) {
        return;
      }
      current_ = jobs_.takeFirst();
      cancelled_ = false;
      current_generation_ = generation_;
      work(lock);
      laying_out_ = false;
      working_.clear();
      MeshJob done = std::move(current_);
      current_ = MeshJob();
      lock.unlock();
      done = MeshJob();  // freed without the lock, which takes long
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
      ready_.reception.refuse(failure);
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
    working_ = "converting " + current_.describe();
    auto message = std::move(current_.message);
    current_.message = nullptr;
    lock.unlock();
    const MeshDataConstPtr mesh = internMesh(convert(*message));
    message = nullptr;
    lock.lock();
    if (!isWanted()) {
      return false;
    }
    ready_.reception.accept();
    eraseIf(ready_.meshes, [&](const auto& other) { return other->uuid == mesh->uuid; });
    eraseIf(ready_.layouts, [&](const auto& other) {
      return other->mesh->uuid == mesh->uuid && other->mesh != mesh;
    });
    jobs_.arrive(mesh);
    ready_.meshes.push_back(mesh);
    current_.mesh = mesh;
    jobs_.applyWish(current_);
    return with_layouts_;
  }

  void layOutCurrent(std::unique_lock<std::mutex>& lock)
  {
    const MeshJob job = current_;
    laying_out_ = true;
    working_ = "laying out " + job.describe();
    lock.unlock();
    MeshLayoutConstPtr layout = findLayout(job.mesh, job.split, job.materials);
    if (!layout) {
      PreviewReceiver receive_preview;
      if (job.split == Split::NONE) {
        receive_preview = [this](const MeshLayoutConstPtr& preview) {
          const std::lock_guard<std::mutex> guard(mutex_);
          deliver(preview);
        };
      }
      layout =
          rviz_mesh_plugin::layOut(job.mesh, job.split, job.materials, cancelled_, receive_preview);
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

  const bool with_layouts_;
  std::mutex mutex_;
  std::condition_variable wake_;
  MeshJobs jobs_;
  Content ready_;
  std::string working_;
  MeshJob current_;
  bool laying_out_ = false;
  bool gave_up_ = false;  ///< the layout before this one, for a newer message
  bool stopped_ = false;
  std::uint64_t generation_ = 0;  ///< counts calls of clear()
  std::uint64_t current_generation_ = 0;
  std::atomic<bool> cancelled_{false};
};

MeshLoader::MeshLoader(bool with_layouts) : worker_(std::make_shared<Worker>(with_layouts)) {}

MeshLoader::~MeshLoader()
{
  worker_->stop();
}

void MeshLoader::start()
{
  const std::lock_guard<std::mutex> lock(starting_);
  if (!thread_) {
    thread_ = std::make_unique<EndingThread>([worker = worker_]() { worker->run(); });
  }
}

void MeshLoader::receive(const mesh_msgs::MeshGeometryStamped::ConstPtr& message,
                         const Flag* dropped)
{
  try {
    start();
    worker_->receive(message, dropped);
  } catch (const std::exception& error) {  // no more threads, or memory
    worker_->refuse(std::string("the mesh cannot be loaded: ") + error.what(), dropped);
  }
}

void MeshLoader::refuse(const std::string& reason, const Flag* dropped)
{
  worker_->refuse(reason, dropped);
}

void MeshLoader::layOut(const MeshDataConstPtr& mesh, Split split,
                        const MaterialsConstPtr& materials)
{
  try {
    start();
    worker_->layOut(mesh, split, materials);
  } catch (const std::exception& error) {
    worker_->refuse(std::string("the mesh cannot be laid out: ") + error.what(), nullptr);
  }
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
