#include "measurement/measurement_list.h"

#include <algorithm>
#include <exception>
#include <map>

namespace rviz_mesh_plugin {

MeasurementList::MeasurementList(std::function<void()> changed) : changed_(std::move(changed)) {}

std::uint32_t MeasurementList::add(MeasurementKind kind, const MeshDataConstPtr& mesh,
                                   const std::string& frame, const std::string& display,
                                   const std::vector<SurfacePoint>& points)
{
  Measurement measurement;
  measurement.number = last_number_ + 1;
  measurement.kind = kind;
  measurement.uuid = mesh->uuid;
  measurement.frame = frame;
  measurement.display = display;
  measurement.points = points;
  measurement.mesh = mesh;
  identities_.push_back(identityOf(*mesh));
  all_.push_back(std::move(measurement));
  ++last_number_;
  startNext();
  changed_();
  return last_number_;
}

void MeasurementList::remove(std::uint32_t number)
{
  const auto found =
      std::find_if(all_.begin(), all_.end(), [&](const auto& one) { return one.number == number; });
  if (found == all_.end()) {
    return;
  }
  if (number == measured_) {
    task_.drop();
    measured_ = 0;
  }
  identities_.erase(identities_.begin() + (found - all_.begin()));
  all_.erase(found);
  startNext();
  changed_();
}

void MeasurementList::clear()
{
  task_.drop();
  measured_ = 0;
  all_.clear();
  identities_.clear();
  changed_();
}

const Measurement* MeasurementList::find(std::uint32_t number) const
{
  const auto found =
      std::find_if(all_.begin(), all_.end(), [&](const auto& one) { return one.number == number; });
  return found == all_.end() ? nullptr : &*found;
}

/// @return whether it has changed
bool MeasurementList::follow(std::size_t i, const std::vector<MeshDataConstPtr>& meshes)
{
  Measurement& measurement = all_[i];
  const MeshDataConstPtr known = measurement.mesh.lock();
  const bool there = known && std::find(meshes.begin(), meshes.end(), known) != meshes.end();
  if (there && !measurement.stale) {
    return false;
  }
  for (const MeshDataConstPtr& mesh : meshes) {
    if (identityOf(*mesh) == identities_[i]) {
      measurement.mesh = mesh;
      measurement.stale = false;
      return true;
    }
  }
  if (measurement.stale) {
    return false;
  }
  measurement.stale = true;
  if (measurement.number == measured_) {
    task_.drop();
    measured_ = 0;
  }
  return true;
}

bool MeasurementList::takeResult()
{
  const auto outcome = task_.take();
  if (!outcome) {
    return false;
  }
  const auto found = std::find_if(all_.begin(), all_.end(),
                                  [&](const auto& one) { return one.number == measured_; });
  measured_ = 0;
  if (found == all_.end()) {
    return false;
  }
  found->state = outcome->result ? Measurement::DONE : Measurement::FAILED;
  found->error = outcome->error;
  if (outcome->result) {
    found->result = outcome->result->surface;
    measured_by_ = outcome->result->thread;
  }
  return true;
}

/// @return whether one has failed
bool MeasurementList::startNext()
{
  for (Measurement& measurement : all_) {
    const MeshDataConstPtr mesh = measurement.mesh.lock();
    if (measured_ != 0 || measurement.state != Measurement::WAITING || measurement.stale || !mesh) {
      continue;
    }
    try {
      task_.start([mesh, kind = measurement.kind,
                   points = measurement.points](const Cancellation& cancellation) {
        return Outcome{measure(*mesh, kind, points, &cancellation.flag()),
                       std::this_thread::get_id()};
      });
      measured_ = measurement.number;
    } catch (const std::exception& error) {  // no thread
      measurement.state = Measurement::FAILED;
      measurement.error = error.what();
      return true;
    }
  }
  return false;
}

void MeasurementList::work(const Meshes& meshes)
{
  bool changed = takeResult();
  std::map<std::string, std::vector<MeshDataConstPtr>> known;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    auto found = known.find(all_[i].uuid);
    if (found == known.end()) {
      found = known.emplace(all_[i].uuid, meshes(all_[i].uuid)).first;
    }
    changed = follow(i, found->second) || changed;
  }
  changed = startNext() || changed;
  if (changed) {
    changed_();
  }
}

}  // namespace rviz_mesh_plugin
