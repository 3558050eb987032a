#include <mesh_map/bvh_selection.h>
#include <mesh_map/footprint.h>
#include <mesh_map/region.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bvh_run.h"
#include "footprint_shape.h"
#include "region_clip.h"

namespace mesh_map {
namespace {

/// The weights of the corners of a triangle at a point of it (equation 1 of the paper).
class TriangleWeights
{
 public:
  explicit TriangleWeights(const float* corners)
      : origin_{double{corners[0]}, double{corners[1]}, double{corners[2]}},
        u_(difference(corners + 3, corners)),
        w_(difference(corners + 6, corners)),
        n_(cross(u_, w_))
  {
  }

  bool exist() const { return dot(n_, n_) > 0.0; }

  double value(const std::array<float, 3>& costs, const Vector3& point) const
  {
    const Vector3 gap = point - origin_;
    const double squared = dot(n_, n_);
    const double gamma = dot(cross(u_, gap), n_) / squared;
    const double beta = dot(cross(gap, w_), n_) / squared;
    return (1.0 - beta - gamma) * costs[0] + beta * costs[1] + gamma * costs[2];
  }

 private:
  Vector3 origin_, u_, w_, n_;
};

/// What is under one footprint after another. Owns scratch memory: one per thread.
class FootprintQuery
{
 public:
  FootprintQuery(const Bvh& bvh, const MeshView& mesh, ArrayView<float> costs,
                 const FootprintShape& shape, FootprintCosts& result)
      : bvh_(bvh), mesh_(mesh), costs_(costs), shape_(shape), result_(result)
  {
  }

  void ask(std::size_t index, const RobotPose& pose)
  {
    samples_.assign(shape_.sampleCount(), 0);
    seen_.clear();
    if (pose.finite()) {
      for (const std::vector<Plane>& piece : shape_.pieces()) {
        planes_.clear();
        for (const Plane& plane : piece) {
          planes_.push_back(pose.plane(plane));
        }
        const ConvexRegion region(planes_);
        for (const std::uint32_t face : selectFaces(bvh_, region)) {
          add(index, pose, region, face);
        }
      }
    }
    std::sort(seen_.begin(), seen_.end());
    seen_.erase(std::unique(seen_.begin(), seen_.end()), seen_.end());
    result_.face_counts[index] = static_cast<std::uint32_t>(seen_.size());
    result_.ground[index] = shape_.share(samples_);
  }

 private:
  void add(std::size_t index, const RobotPose& pose, const ConvexRegion& region, std::uint32_t face)
  {
    std::array<float, 9> corners;
    std::array<float, 3> costs;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t vertex = mesh_.faces[3 * std::size_t{face} + k];
      std::copy_n(mesh_.positions.data() + 3 * vertex, 3, corners.data() + 3 * k);
      costs[k] = costs_[vertex];
    }
    seen_.push_back(face);
    const bool lethal =
        std::any_of(costs.begin(), costs.end(), [](float cost) { return std::isinf(cost); });
    const bool unknown =
        std::any_of(costs.begin(), costs.end(), [](float cost) { return std::isnan(cost); });
    result_.lethal[index] |= lethal ? 1 : 0;
    result_.unknown[index] |= unknown ? 1 : 0;

    ClippedTriangle part(corners.data());
    for (const Plane& plane : region.planes()) {
      part.cut(plane);
    }
    const TriangleWeights weights(corners.data());
    const float low = std::min({costs[0], costs[1], costs[2]});
    const float high = std::max({costs[0], costs[1], costs[2]});
    outline_.clear();
    double cost = weights.exist() && !part.empty() ? low : high;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Vector3 local = pose.local(part[i]);
      outline_.push_back({local[0], local[1]});
      cost = weights.exist() ? std::max(cost, weights.value(costs, part[i])) : cost;
    }
    if (!lethal && !unknown) {
      result_.max_costs[index] =
          std::max(result_.max_costs[index], std::min(high, static_cast<float>(cost)));
    }
    if (!outline_.empty()) {
      shape_.mark(outline_, samples_);
    }
  }

  const Bvh& bvh_;
  const MeshView& mesh_;
  ArrayView<float> costs_;
  const FootprintShape& shape_;
  FootprintCosts& result_;
  std::vector<Plane> planes_;
  std::vector<std::uint8_t> samples_;
  std::vector<std::uint32_t> seen_;
  std::vector<Point2> outline_;
};

}  // namespace

FootprintCosts footprintCosts(const Bvh& bvh, const MeshView& mesh, ArrayView<float> costs,
                              const Footprint& footprint, ArrayView<double> poses,
                              const BvhOptions& run_options)
{
  if (bvh.faceCount() != mesh.faceCount() || costs.size() != mesh.vertexCount() ||
      poses.size() % 12 != 0) {
    throw std::invalid_argument("one cost per vertex and 12 numbers per pose are needed");
  }
  const FootprintShape shape(footprint);
  const std::size_t count = poses.size() / 12;
  FootprintCosts result;
  result.max_costs.assign(count, 0.0f);
  result.lethal.assign(count, 0);
  result.unknown.assign(count, 0);
  result.ground.assign(count, 0.0);
  result.face_counts.assign(count, 0);

  Run run(run_options);
  constexpr std::size_t chunk = 16;
  run.loop(count, chunk, 1.0, [&]() -> RangeBody {
    return [&, query = FootprintQuery(bvh, mesh, costs, shape, result)](std::size_t begin,
                                                                        std::size_t end) mutable {
      for (std::size_t i = begin; i < end; ++i) {
        run.check();
        query.ask(i, RobotPose(poses.data() + 12 * i));
      }
    };
  });
  run.finish();
  return result;
}

}  // namespace mesh_map
