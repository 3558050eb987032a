#include "incoming/mesh_loader.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <iterator>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <utility>

#include "base/erase_if.h"
#include "base/large_blocks.h"
#include "base/status_lines.h"
#include "conversion/mesh_conversion.h"

namespace rviz_mesh_plugin {
namespace {

struct Registry
{
  std::mutex mutex;
  std::vector<std::weak_ptr<const MeshData>> meshes;
  std::vector<std::weak_ptr<const MeshLayout>> layouts;
  std::set<std::string> turns;  ///< uuids of the messages that are being converted
  std::condition_variable turn_ended;
};

/// Never destroyed: threads may still use it while the process ends.
Registry& registry()
{
  static Registry& instance = *new Registry;
  return instance;
}

/// Instead of what is not in use any more.
template <class T>
void remember(std::vector<std::weak_ptr<const T>>& entries, const std::shared_ptr<const T>& entry)
{
  eraseIf(entries, [](const auto& other) { return other.expired(); });
  entries.push_back(entry);
}

/// While it is there, no other thread has one for the same uuid.
class Turn
{
 public:
  explicit Turn(const std::string& uuid) : uuid_(uuid)
  {
    std::unique_lock<std::mutex> lock(registry().mutex);
    registry().turn_ended.wait(lock, [&] { return registry().turns.insert(uuid_).second; });
  }
  ~Turn()
  {
    const std::lock_guard<std::mutex> lock(registry().mutex);
    registry().turns.erase(uuid_);
    registry().turn_ended.notify_all();
  }

 private:
  const std::string uuid_;
};

/// The mesh of a message: the one that is in use in this process, where it has the same content,
/// name and frame, to the last bit; else a new one. A message that several threads get is converted
/// by one of them, while the others wait for it. Keeps nothing alive. Thread safe.
/// @throw as convert()
MeshDataConstPtr sharedMesh(const mesh_msgs::MeshGeometryStamped& message)
{
  const Turn turn(message.uuid);
  auto& entries = registry();
  std::unique_lock<std::mutex> lock(entries.mutex);
  const std::vector<std::weak_ptr<const MeshData>> in_use = entries.meshes;
  lock.unlock();
  for (const auto& entry : in_use) {
    const MeshDataConstPtr known = entry.lock();
    if (known && isConverted(message, *known)) {
      return known;
    }
  }
  const MeshDataConstPtr mesh = convert(message);
  lock.lock();
  remember(entries.meshes, mesh);
  return mesh;
}

/// The layout in use in this process that has been made of these, or null. Thread safe.
MeshLayoutConstPtr findLayout(const MeshDataConstPtr& mesh, Split split,
                              const MaterialsConstPtr& materials, const HiddenFacesConstPtr& hidden)
{
  auto& entries = registry();
  const std::lock_guard<std::mutex> lock(entries.mutex);
  for (const auto& entry : entries.layouts) {
    const MeshLayoutConstPtr known = entry.lock();
    if (known && known->mesh == mesh && known->split == split && known->hidden == hidden &&
        (split != Split::BY_MATERIAL || known->materials == materials)) {
      return known;
    }
  }
  return nullptr;
}

/// A message to convert, or a mesh to lay out.
struct MeshJob
{
  std::string uuid;
  mesh_msgs::MeshGeometryStamped::ConstPtr message;
  std::string service;  ///< that the message is the answer of, if it is
  MeshDataConstPtr mesh;
  Split split = Split::NONE;
  MaterialsConstPtr materials;
  HiddenFacesConstPtr hidden;

  bool isSameLayout(const MeshJob& other) const
  {
    return mesh == other.mesh && split == other.split && materials == other.materials &&
           hidden == other.hidden;
  }

  std::string describe() const
  {
    const std::size_t faces = message ? message->mesh_geometry.faces.size() : mesh->faceCount();
    return std::to_string(faces) + " faces of mesh " + quotedName(uuid);
  }
};

/// What a MeshLoader has to do, and how each mesh was asked to be laid out last.
class MeshJobs
{
 public:
  /// Messages of more meshes than this do not wait.
  static constexpr std::size_t MOST_MESSAGES = 16;

  /// In place of an older message of the mesh; where too many wait, the oldest goes.
  /// @param dropped jobs that are in the way: to free them takes long
  /// @return what is refused and why, else empty
  std::string add(const mesh_msgs::MeshGeometryStamped::ConstPtr& message,
                  const std::string& service, std::vector<MeshJob>& dropped)
  {
    const auto older = std::stable_partition(
        waiting_.begin(), waiting_.end(),
        [&](const auto& job) { return !job.message || job.uuid != message->uuid; });
    std::move(older, waiting_.end(), std::back_inserter(dropped));
    waiting_.erase(older, waiting_.end());
    std::string refusal;
    const auto is_message = [](const MeshJob& job) { return job.message != nullptr; };
    const auto messages = std::count_if(waiting_.begin(), waiting_.end(), is_message);
    if (static_cast<std::size_t>(messages) >= MOST_MESSAGES) {
      const auto oldest = std::find_if(waiting_.begin(), waiting_.end(), is_message);
      refusal = "mesh " + quotedName(oldest->uuid) + " was dropped, because " +
                std::to_string(MOST_MESSAGES) +
                " more arrived before it could be shown; publish them more slowly";
      dropped.push_back(std::move(*oldest));
      waiting_.erase(oldest);
    }
    MeshJob job;
    job.uuid = message->uuid;
    job.message = message;
    job.service = service;
    waiting_.push_back(std::move(job));
    return refusal;
  }

  /// Remembers how a mesh is to be laid out, and removes what was asked before.
  void setWish(const MeshJob& layout)
  {
    eraseIf(waiting_, [&](const auto& other) { return other.mesh && other.uuid == layout.uuid; });
    eraseIf(wishes_, [](const auto& wish) { return wish.second.mesh.expired(); });
    wishes_[layout.uuid] = {layout.mesh, layout.split, layout.materials};
  }
  void add(MeshJob layout) { waiting_.push_back(std::move(layout)); }

  /// The mesh has come: layouts of another one of that uuid are obsolete.
  void arrive(const MeshDataConstPtr& mesh)
  {
    eraseIf(waiting_, [&](const auto& job) {
      return job.mesh && job.uuid == mesh->uuid && job.mesh != mesh;
    });
  }

  /// How the mesh of a job was asked to be laid out last; nothing changes where it was not.
  void applyWish(MeshJob& job) const
  {
    const auto wish = wishes_.find(job.mesh->uuid);
    if (wish != wishes_.end() && wish->second.mesh.lock() == job.mesh) {
      job.split = wish->second.split;
      job.materials = wish->second.materials.lock();
      if (job.split == Split::BY_MATERIAL && !job.materials) {
        job.split = Split::NONE;
      }
    }
  }

  bool empty() const { return waiting_.empty(); }

  MeshJob takeFirst()
  {
    MeshJob job = std::move(waiting_.front());
    waiting_.pop_front();
    return job;
  }

 private:
  struct Wish
  {
    std::weak_ptr<const MeshData> mesh;
    Split split = Split::NONE;
    std::weak_ptr<const Materials> materials;
  };

  std::deque<MeshJob> waiting_;
  std::map<std::string, Wish> wishes_;  ///< by uuid
};

}  // namespace

/// Shared by the loader and its thread, which may outlive it.
class MeshLoader::Worker
{
 public:
  explicit Worker(bool with_layouts) : with_layouts_(with_layouts) {}

  /// @param wake has workOnce() called, after this
  template <class Wake>
  void receive(const mesh_msgs::MeshGeometryStamped::ConstPtr& message, const Origin& origin,
               const Wake& wake)
  {
    std::vector<MeshJob> removed;  // freed without the lock, which takes long
    const std::lock_guard<std::mutex> lock(mutex_);
    if (origin.isDropped()) {
      return;
    }
    wake();
    const std::string refusal = jobs_.add(message, origin.service, removed);
    if (!refusal.empty()) {
      ready_.reception.refuse(refusal);
      if (given_up_.mesh && removed.back().uuid == given_up_.uuid) {
        jobs_.add(std::exchange(given_up_, MeshJob()));  // at the turn of what was dropped
      }
    }
    // Never twice in a row: else a fast publisher would not be shown at all.
    if (laying_out_ && current_.uuid == message->uuid && !gave_up_) {
      canceled_ = gave_up_ = true;
      given_up_ = current_;
    }
  }

  void refuse(const std::string& reason, const Origin& origin)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!origin.isDropped()) {
      ready_.reception.refuse(reason, origin.service);
    }
  }

  template <class Wake>
  void layOut(const MeshDataConstPtr& mesh, Split split, const MaterialsConstPtr& materials,
              const Wake& wake)
  {
    MeshJob job;
    job.uuid = mesh->uuid;
    job.mesh = mesh;
    job.split = split;
    job.materials = split == Split::BY_MATERIAL ? materials : nullptr;
    job.hidden = hiddenFaces(*mesh);
    const std::lock_guard<std::mutex> lock(mutex_);
    wake();
    jobs_.setWish(job);
    if (laying_out_ && current_.mesh == mesh && !canceled_) {
      if (current_.isSameLayout(job)) {
        return;
      }
      canceled_ = true;
    }
    jobs_.add(std::move(job));
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
    jobs_ = MeshJobs();
    ready_ = Content();
    working_.clear();
    canceled_ = true;
    gave_up_ = false;
    given_up_ = MeshJob();
    ++generation_;
  }

  /// The next job, if there is one: on the thread.
  void workOnce()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    if (jobs_.empty()) {
      return;
    }
    current_ = jobs_.takeFirst();
    canceled_ = false;
    current_generation_ = generation_;
    work(lock);
    laying_out_ = false;
    working_.clear();
    const MeshJob done = std::exchange(current_, MeshJob());
    const bool again = std::exchange(again_, false);
    lock.unlock();  // it is freed without the lock, which takes long
    if (again) {
      workOnce();
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
    } catch (const std::bad_alloc&) {
      failure = "there is not enough memory; close programs, or make the mesh smaller";
    } catch (const std::exception& error) {
      failure = error.what();
    }
    if (!lock.owns_lock()) {
      lock.lock();
    }
    if (isWanted()) {
      ready_.reception.refuse(failure, current_.service);
      if (given_up_.mesh && given_up_.uuid == current_.uuid && !current_.mesh) {
        jobs_.add(std::exchange(given_up_, MeshJob()));  // for a message that is none
        again_ = true;
      }
    }
  }

  /// False where there is nothing to lay out.
  bool load(std::unique_lock<std::mutex>& lock)
  {
    working_ = "converting " + current_.describe();
    auto message = std::move(current_.message);
    current_.message = nullptr;
    lock.unlock();
    const MeshDataConstPtr mesh = sharedMesh(*message);
    message = nullptr;
    lock.lock();
    if (!isWanted()) {
      return false;
    }
    ready_.reception.accept(current_.service);
    if (given_up_.uuid == mesh->uuid) {
      given_up_ = MeshJob();
    }
    eraseIf(ready_.meshes, [&](const auto& other) { return other->uuid == mesh->uuid; });
    eraseIf(ready_.layouts, [&](const auto& other) {
      return other->mesh->uuid == mesh->uuid && other->mesh != mesh;
    });
    jobs_.arrive(mesh);
    ready_.meshes.push_back(mesh);
    current_.mesh = mesh;
    current_.hidden = hiddenFaces(*mesh);
    jobs_.applyWish(current_);
    return with_layouts_;
  }

  void layOutCurrent(std::unique_lock<std::mutex>& lock)
  {
    const MeshJob job = current_;
    laying_out_ = true;
    working_ = "laying out " + job.describe();
    lock.unlock();
    MeshLayoutConstPtr layout = findLayout(job.mesh, job.split, job.materials, job.hidden);
    if (!layout) {
      if (job.split == Split::NONE && !job.hidden && job.mesh->faceCount() > preview_threshold &&
          !canceled_) {
        const MeshLayoutConstPtr preview = layOutPreview(job.mesh);
        const std::lock_guard<std::mutex> guard(mutex_);
        deliver(preview);
      }
      layout = rviz_mesh_plugin::layOut(job.mesh, job.split, job.materials, canceled_, job.hidden);
      if (layout) {
        const std::lock_guard<std::mutex> guard(registry().mutex);
        remember(registry().layouts, layout);
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

  bool isWanted() const { return current_generation_ == generation_; }

  const bool with_layouts_;
  std::mutex mutex_;
  MeshJobs jobs_;
  Content ready_;
  std::string working_;
  MeshJob current_;
  bool laying_out_ = false;
  bool gave_up_ = false;          ///< the layout before this one, for a newer message
  MeshJob given_up_;              ///< that one, until that message has been converted
  bool again_ = false;            ///< there is a job more than workOnce() is called for
  std::uint64_t generation_ = 0;  ///< counts calls of clear()
  std::uint64_t current_generation_ = 0;
  std::atomic<bool> canceled_{false};
};

MeshLoader::MeshLoader(bool with_layouts) : worker_(std::make_shared<Worker>(with_layouts))
{
  giveLargeBlocksBack();
}

MeshLoader::~MeshLoader()
{
  worker_->clear();
}

void MeshLoader::wake()
{
  thread_.add([worker = worker_](const Cancellation&) { worker->workOnce(); });
}

void MeshLoader::receive(const mesh_msgs::MeshGeometryStamped::ConstPtr& message,
                         const Origin& origin)
{
  try {
    worker_->receive(message, origin, [this] { wake(); });
  } catch (const std::exception& error) {  // no more threads, or memory
    worker_->refuse(std::string("the mesh cannot be loaded: ") + error.what(), origin);
  }
}

void MeshLoader::refuse(const std::string& reason, const Origin& origin)
{
  worker_->refuse(reason, origin);
}

void MeshLoader::layOut(const MeshDataConstPtr& mesh, Split split,
                        const MaterialsConstPtr& materials)
{
  try {
    worker_->layOut(mesh, split, materials, [this] { wake(); });
  } catch (const std::exception& error) {
    worker_->refuse(std::string("the mesh cannot be laid out: ") + error.what(), {});
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
