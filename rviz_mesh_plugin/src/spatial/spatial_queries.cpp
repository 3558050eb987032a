#include "spatial/spatial_queries.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "spatial/device_queries.h"
#include "spatial/opencl_device.h"

namespace rviz_mesh_plugin {

using mesh_map::ArrayView;
using mesh_map::BackEnd;
using mesh_map::BvhOptions;
using mesh_map::Query;

namespace {

std::shared_ptr<const mesh_map::Bvh> checked(std::shared_ptr<const mesh_map::Bvh> bvh)
{
  if (!bvh) {
    throw std::invalid_argument("SpatialQueries needs a hierarchy");
  }
  return bvh;
}

std::shared_ptr<OpenClSession> startSession(const SpatialQueriesOptions& options)
{
  const std::string wish = deviceWish(options.device);
  return wish == "off" ? nullptr : OpenClSession::shared(wish, options.cache_folder, options.log);
}

/// Faces in the subtrees of mesh_map::selectionRoots().
std::size_t facesBelow(const mesh_map::Bvh& bvh, const std::vector<std::uint32_t>& roots)
{
  std::size_t faces = 0;
  for (std::size_t i = 0; i < roots.size(); i += 2) {
    if (mesh_map::isLeaf(roots[i])) {
      faces += roots[i + 1];
    } else {
      const mesh_map::BvhNode& node = bvh.nodes()[roots[i]];
      faces = std::accumulate(std::begin(node.count), std::end(node.count), faces);
    }
  }
  return faces;
}

bool isSphere(const mesh_map::Region& region)
{
  return dynamic_cast<const mesh_map::SphereRegion*>(&region) != nullptr;
}

/// mesh_map::selectionRoots() knows regions of that kind.
bool hasRoots(const mesh_map::Region& region)
{
  return isSphere(region) || dynamic_cast<const mesh_map::ConvexRegion*>(&region) != nullptr;
}

}  // namespace

SpatialQueries::SpatialQueries(std::shared_ptr<const mesh_map::Bvh> bvh,
                               const SpatialQueriesOptions& options)
    : bvh_(checked(std::move(bvh))),
      device_threshold_(options.device_threshold),
      session_(startSession(options))
{
}

SpatialQueries::~SpatialQueries() = default;

bool SpatialQueries::waitForDevice() const
{
  return session_ && session_->wait() && device(Query::RAY, SIZE_MAX) != nullptr;
}

/// The device where so many are to be answered by it, without the mesh; else null.
std::shared_ptr<const OpenClProgram> SpatialQueries::paysOnDevice(Query query,
                                                                  std::size_t count) const
{
  auto program = session_ ? session_->program() : nullptr;
  const bool is_gpu = program && program->info.type == DeviceType::GPU;
  const bool pays =
      program && count >= std::max<std::size_t>(1, device_threshold_.value_or(
                                                       mesh_map::deviceThreshold(query, is_gpu)));
  return pays ? program : nullptr;
}

/// The device with the mesh, which is uploaded first, if it shall answer; null if not.
std::shared_ptr<const DeviceQueries> SpatialQueries::device(Query query, std::size_t count) const
{
  const auto program = paysOnDevice(query, count);
  if (!program) {
    return nullptr;
  }
  std::shared_ptr<const DeviceQueries> device;
  std::string failure, warning;  // for the log, which may ask back
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!device_ && !refused_) {
      const std::string refusal = DeviceQueries::refusal(*program, *bvh_);
      if (refusal.empty()) {
        try {
          device_ = std::make_shared<const DeviceQueries>(program, *bvh_);
        } catch (const cl::Error& error) {
          failure = describe(error);
        }
      } else {
        refused_ = true;
        warning = "OpenCL: " + refusal + "; queries are answered natively";
      }
    }
    device = device_;
  }
  if (!failure.empty()) {
    session_->fail(failure);
  }
  if (!warning.empty()) {
    session_->warn(warning);
  }
  return device;
}

/// Lets the device answer, or begin to. Where it fails, that was it.
void SpatialQueries::onDevice(Query query, std::size_t count,
                              const std::function<void(const DeviceQueries&)>& ask) const
{
  if (const auto asked = device(query, count)) {
    try {
      ask(*asked);
    } catch (const cl::Error& error) {
      session_->fail(describe(error));
      const std::lock_guard<std::mutex> lock(mutex_);
      device_.reset();
    }
  }
}

mesh_map::RayHit SpatialQueries::castRay(const mesh_map::Ray& ray,
                                         const mesh_map::RayOptions& options) const
{
  return mesh_map::castRay(*bvh_, ray, options);
}

mesh_map::RayHits SpatialQueries::castRays(const mesh_map::RayBatch& rays,
                                           const BvhOptions& run) const
{
  BvhOptions without_progress = run;
  without_progress.progress = nullptr;
  mesh_map::RayHits hits;
  const std::size_t count = rays.size();
  if (consistent(rays)) {
    onDevice(Query::RAY, count,
             [&](const DeviceQueries& device) { device.castRays(rays, without_progress, hits); });
  }
  const std::size_t done = hits.faces.size();
  mesh_map::countQueries(BackEnd::OPENCL, Query::RAY, done);
  if (done == 0) {
    return mesh_map::castRays(*bvh_, rays, {}, without_progress);
  }
  if (done < count) {
    append(hits, mesh_map::castRays(*bvh_, slice(rays, done, count), {}, without_progress));
  }
  return hits;
}

std::size_t SpatialQueries::mostFaces(const mesh_map::Region& region) const
{
  return hasRoots(region) ? facesBelow(*bvh_, mesh_map::selectionRoots(*bvh_, region))
                          : bvh_->faceCount();
}

std::vector<std::uint32_t> SpatialQueries::selectFaces(const mesh_map::Region& region,
                                                       const BvhOptions& run) const
{
  const Query query = isSphere(region) ? Query::SPHERE : Query::FRUSTUM;
  std::vector<std::uint32_t> faces;
  bool answered = false;
  // Of a mesh that is too small as a whole, nothing needs to be looked at.
  if (hasRoots(region) && paysOnDevice(query, bvh_->faceCount())) {
    const auto roots = mesh_map::selectionRoots(*bvh_, region);
    onDevice(query, facesBelow(*bvh_, roots), [&](const DeviceQueries& device) {
      faces = device.selectFaces(region, roots, run);
      answered = true;
    });
  }
  if (!answered) {
    return mesh_map::selectFaces(*bvh_, region, mesh_map::SelectionMode::TOUCHING, {}, run);
  }
  mesh_map::countQueries(BackEnd::OPENCL, query, 1);
  return faces;
}

std::vector<std::uint32_t> SpatialQueries::seenFaces(const mesh_map::Region& region,
                                                     ArrayView<std::uint32_t> faces,
                                                     const std::array<double, 3>& eye,
                                                     const BvhOptions& run) const
{
  return mesh_map::seenFaces(*bvh_, region, faces, eye,
                             [&](const mesh_map::RayBatch& rays) { return castRays(rays, run); });
}

}  // namespace rviz_mesh_plugin
