#include "rviz_mesh_plugin/mesh_jobs.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace rviz_mesh_plugin {
namespace {

bool isMessage(const MeshJob& job)
{
  return job.message != nullptr;
}

template <class Predicate>
void eraseIf(std::deque<MeshJob>& jobs, const Predicate& predicate)
{
  jobs.erase(std::remove_if(jobs.begin(), jobs.end(), predicate), jobs.end());
}

}  // namespace

std::string MeshJob::describe() const
{
  const std::size_t faces = message ? message->mesh_geometry.faces.size() : mesh->faceCount();
  return std::to_string(faces) + " faces of mesh '" + uuid + "'";
}

std::string MeshJobs::add(const mesh_msgs::MeshGeometryStamped::ConstPtr& message,
                          std::vector<MeshJob>& dropped)
{
  const auto older = std::stable_partition(waiting_.begin(), waiting_.end(), [&](const auto& job) {
    return !isMessage(job) || job.uuid != message->uuid;
  });
  std::move(older, waiting_.end(), std::back_inserter(dropped));
  waiting_.erase(older, waiting_.end());
  std::string refusal;
  const auto messages = std::count_if(waiting_.begin(), waiting_.end(), isMessage);
  if (static_cast<std::size_t>(messages) >= MOST_MESSAGES) {
    const auto oldest = std::find_if(waiting_.begin(), waiting_.end(), isMessage);
    refusal = "mesh '" + oldest->uuid + "' was dropped, because " + std::to_string(MOST_MESSAGES) +
              " more arrived before it could be shown; publish them more slowly";
    dropped.push_back(std::move(*oldest));
    waiting_.erase(oldest);
  }
  MeshJob job;
  job.uuid = message->uuid;
  job.message = message;
  waiting_.push_back(std::move(job));
  return refusal;
}

void MeshJobs::setWish(const MeshJob& layout)
{
  eraseIf(waiting_, [&](const auto& other) { return other.mesh && other.uuid == layout.uuid; });
  for (auto wish = wishes_.begin(); wish != wishes_.end();) {
    wish = wish->second.mesh.expired() ? wishes_.erase(wish) : std::next(wish);
  }
  wishes_[layout.uuid] = {layout.mesh, layout.split, layout.materials};
}

void MeshJobs::arrive(const MeshDataConstPtr& mesh)
{
  eraseIf(waiting_,
          [&](const auto& job) { return job.mesh && job.uuid == mesh->uuid && job.mesh != mesh; });
}

void MeshJobs::applyWish(MeshJob& job) const
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

MeshJob MeshJobs::takeFirst()
{
  MeshJob job = std::move(waiting_.front());
  waiting_.pop_front();
  return job;
}

void MeshJobs::clear()
{
  waiting_.clear();
  wishes_.clear();
}

}  // namespace rviz_mesh_plugin
