#include "rviz_mesh_plugin/way_measurement.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <new>
#include <utility>

#include "rviz_mesh_plugin/cancellation.h"

namespace rviz_mesh_plugin {

struct WayMeasurement::Job
{
  std::atomic<bool> cancelled{false};
  std::mutex mutex;
  std::optional<Result> result;
};

void WayMeasurement::start(const MeshDataConstPtr& mesh, const SurfacePoint& from,
                           const SurfacePoint& to)
{
  cancel();
  auto job = std::make_shared<Job>();
  lanes_.add("ways", [job, mesh, from, to] {
    Result result;
    try {
      result.way = findWay(*mesh, from, to, &job->cancelled);
    } catch (const Cancelled&) {  // nobody waits for it
    } catch (const std::bad_alloc&) {
      result.failure = "there is not enough memory";
    } catch (const std::exception& error) {
      result.failure = error.what();
    }
    const std::lock_guard<std::mutex> lock(job->mutex);
    job->result = std::move(result);
  });
  job_ = std::move(job);
}

std::optional<WayMeasurement::Result> WayMeasurement::take()
{
  std::optional<Result> result;
  if (job_) {
    const std::lock_guard<std::mutex> lock(job_->mutex);
    result.swap(job_->result);
  }
  if (result) {
    job_.reset();
  }
  return result;
}

void WayMeasurement::cancel()
{
  if (job_) {
    job_->cancelled = true;
    job_.reset();
  }
}

}  // namespace rviz_mesh_plugin
