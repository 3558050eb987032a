#include <mesh_map/bvh_selection.h>
#include <mesh_map/footprint_vertices.h>
#include <mesh_map/region.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "bvh_run.h"
#include "footprint_shape.h"
#include "region_clip.h"

namespace mesh_map {
namespace {

/// Keeps what of a convex polygon has a coordinate of 0 or more.
void keepUpperPart(const std::vector<Point2>& polygon, std::size_t axis, std::vector<Point2>& kept)
{
  kept.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 &p = polygon[i], &q = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    if (p[axis] >= 0.0) {
      kept.push_back(p);
    }
    if ((p[axis] < 0.0) != (q[axis] < 0.0)) {
      const double t = p[axis] / (p[axis] - q[axis]);
      Point2 crossing{p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])};
      crossing[axis] = 0.0;
      kept.push_back(crossing);
    }
  }
}

/// How much nearer a point is to one place than to another: linear in the point, 0 half-way.
double nearness(const Vector3& point, const Vector3& to, const Vector3& than)
{
  const Vector3 away = than - to;
  return 0.5 * dot(away, away) - dot(point - to, away);
}

/// What is under one footprint after another. Owns scratch memory: one per thread.
class VerticesQuery
{
 public:
  VerticesQuery(const Bvh& bvh, const MeshView& mesh, const FootprintShape& shape)
      : bvh_(bvh), mesh_(mesh), shape_(shape)
  {
  }

  std::vector<std::uint32_t> under(const RobotPose& pose)
  {
    found_.clear();
    if (pose.finite()) {
      for (const std::vector<Plane>& piece : shape_.pieces()) {
        planes_.clear();
        for (const Plane& plane : piece) {
          planes_.push_back(pose.plane(plane));
        }
        const ConvexRegion region(planes_);
        for (const std::uint32_t face : selectFaces(bvh_, region)) {
          add(face);
        }
      }
    }
    std::sort(found_.begin(), found_.end());
    found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    return found_;
  }

 private:
  void add(std::uint32_t face)
  {
    std::array<float, 9> corners;
    const std::uint32_t* const vertices = mesh_.faces.data() + 3 * std::size_t{face};
    for (std::size_t k = 0; k < 3; ++k) {
      std::copy_n(mesh_.positions.data() + 3 * std::size_t{vertices[k]}, 3, corners.data() + 3 * k);
    }
    const PlaneSides sides = planeSides(planes_, ALL_PLANES, corners.data());
    if (sides.outside == 0 && sides.cutting == 0) {
      found_.insert(found_.end(), vertices, vertices + 3);
      return;
    }
    ClippedTriangle part(corners.data());
    for (std::size_t i = 0; i < planes_.size(); ++i) {
      if (((sides.outside | sides.cutting) >> i & 1u) != 0) {
        part.cut(planes_[i]);
      }
    }
    const auto corner = [&](std::size_t k) {
      return Vector3{double{corners[3 * k]}, double{corners[3 * k + 1]},
                     double{corners[3 * k + 2]}};
    };
    for (std::size_t k = 0; k < 3; ++k) {
      if (reaches(part, corner(k), corner((k + 1) % 3), corner((k + 2) % 3))) {
        found_.push_back(vertices[k]);
      }
    }
  }

  /// Whether a point of the polygon is as near to one place as to two others.
  bool reaches(const ClippedTriangle& part, const Vector3& to, const Vector3& first,
               const Vector3& second)
  {
    outline_.clear();
    for (std::size_t i = 0; i < part.size(); ++i) {
      outline_.push_back({nearness(part[i], to, first), nearness(part[i], to, second)});
    }
    keepUpperPart(outline_, 0, half_);
    keepUpperPart(half_, 1, quarter_);
    return !quarter_.empty();
  }

  const Bvh& bvh_;
  const MeshView& mesh_;
  const FootprintShape& shape_;
  std::vector<Plane> planes_;
  std::vector<std::uint32_t> found_;
  std::vector<Point2> outline_, half_, quarter_;
};

}  // namespace

FootprintVertices footprintVertices(const Bvh& bvh, const MeshView& mesh,
                                    const Footprint& footprint, ArrayView<double> poses,
                                    const BvhOptions& run_options)
{
  if (bvh.faceCount() != mesh.faceCount() || poses.size() % 12 != 0) {
    throw std::invalid_argument("the hierarchy of the mesh and 12 numbers per pose are needed");
  }
  const FootprintShape shape(footprint);
  std::vector<std::vector<std::uint32_t>> rows(poses.size() / 12);
  Run run(run_options);
  constexpr std::size_t chunk = 16;
  run.loop(rows.size(), chunk, 1.0, [&]() -> RangeBody {
    return
        [&, query = VerticesQuery(bvh, mesh, shape)](std::size_t begin, std::size_t end) mutable {
          for (std::size_t i = begin; i < end; ++i) {
            run.check();
            rows[i] = query.under(RobotPose(poses.data() + 12 * i));
          }
        };
  });
  run.finish();

  FootprintVertices result{{0}, {}};
  for (const std::vector<std::uint32_t>& row : rows) {
    result.vertices.insert(result.vertices.end(), row.begin(), row.end());
    result.offsets.push_back(result.vertices.size());
  }
  return result;
}

}  // namespace mesh_map
