#include "paths/footprint.h"

#include <mesh_map/bvh/selection/bvh_selection.h>
#include <mesh_map/bvh/selection/region.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <vector>

#include "base/require.h"
#include "base/run.h"
#include "base/unique.h"
#include "base/vector3.h"
#include "bvh/selection/region_clip.h"

namespace mesh_map {

namespace {

/// Poses that a thread takes at once.
constexpr std::size_t CHUNK = 16;

/// Where a robot is: the rows of its matrix.
class RobotPose
{
 public:
  explicit RobotPose(const double* numbers)
  {
    for (std::size_t i = 0; i < 3; ++i) {
      rows_[i] = {numbers[4 * i], numbers[4 * i + 1], numbers[4 * i + 2]};
      shift_[i] = numbers[4 * i + 3];
      finite_ = finite_ && isFinite(rows_[i]) && std::isfinite(shift_[i]);
    }
  }

  bool finite() const { return finite_; }

  /// A plane of the frame of the robot in that of the mesh.
  Plane plane(const Plane& robot) const
  {
    const Vector3 normal{robot[0], robot[1], robot[2]};
    const Vector3 turned{dot(rows_[0], normal), dot(rows_[1], normal), dot(rows_[2], normal)};
    return {turned[0], turned[1], turned[2], robot[3] - dot(turned, shift_)};
  }

  /// A point of the mesh in the frame of the robot.
  Vector3 local(const Vector3& point) const
  {
    const Vector3 gap = point - shift_;
    return gap[0] * rows_[0] + gap[1] * rows_[1] + gap[2] * rows_[2];
  }

 private:
  std::array<Vector3, 3> rows_;
  Vector3 shift_;
  bool finite_ = true;
};

/// Corners of a piece: its sides and the two ends of the band are planes.
constexpr std::size_t MOST_CORNERS = ConvexRegion::MAX_PLANES - 2;

Plane leftOf(const Vector2& from, const Vector2& to)
{
  const double a = from[1] - to[1], b = to[0] - from[0];
  return {a, b, 0.0, -(a * from[0] + b * from[1])};
}

/// From where to where a convex polygon reaches at a height; empty (from > to) where it does not.
std::array<double, 2> reachAt(const std::vector<Vector2>& polygon, double y)
{
  std::array<double, 2> reach{std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    if (std::min(p[1], q[1]) > y || std::max(p[1], q[1]) < y) {
      continue;
    }
    for (const Vector2* end : {&p, &q}) {
      const double x = p[1] == q[1] ? (*end)[0] : p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
      reach = {std::min(reach[0], x), std::max(reach[1], x)};
    }
  }
  return reach;
}

/// A footprint, ready to be asked.
class FootprintShape
{
 public:
  /// Throws std::invalid_argument for a polygon that is not convex and counter-clockwise.
  explicit FootprintShape(const Footprint& footprint)
  {
    const std::vector<Vector2>& corners = footprint.corners;
    const std::size_t count = corners.size();
    bool convex = count >= 3 && footprint.lowest <= footprint.highest;
    double turned = 0.0;
    for (std::size_t i = 0; convex && i < count; ++i) {
      const Vector2 &p = corners[i], &q = corners[(i + 1) % count], &r = corners[(i + 2) % count];
      const Vector2 side = q - p, next = r - q;
      const double turn = cross(side, next);
      convex = std::isfinite(turn) && turn >= 0.0 && side != Vector2{};
      turned += std::atan2(turn, dot(side, next));
    }
    require(convex && std::abs(turned - 2.0 * PI) <= 1e-3,
            "the footprint has to be convex and counter-clockwise, with a band"
            " from its lowest to its highest z");
    for (std::size_t first = 1; first + 1 < count; first += MOST_CORNERS - 2) {
      addPiece(footprint, first, std::min(count - 1, first + MOST_CORNERS - 2));
    }
    addSamples(corners);
  }

  /// The band, cut into pieces of few enough planes for a ConvexRegion.
  const std::vector<std::vector<Plane>>& pieces() const { return pieces_; }

  /// Points of the polygon: the centers of the cells of a grid. In rows.
  std::size_t sampleCount() const { return sample_count_; }

  /// Marks the samples in a convex polygon, whichever way round it runs.
  void mark(const std::vector<Vector2>& polygon, std::vector<std::uint8_t>& samples) const
  {
    for (const Row& row : rows_) {
      const std::array<double, 2> reach = reachAt(polygon, row.y);
      const double slack = 1e-9 * step_;  // so that no sample is lost between two faces
      const double first = std::ceil((reach[0] - slack - row.first_x) / step_);
      const double last = std::floor((reach[1] + slack - row.first_x) / step_);
      const auto most = static_cast<double>(row.count) - 1.0;
      for (double k = std::max(0.0, first); k <= std::min(most, last); k += 1.0) {
        samples[row.begin + static_cast<std::size_t>(k)] = 1;
      }
    }
  }

  /// Share of the samples that are marked.
  double share(const std::vector<std::uint8_t>& samples) const
  {
    const auto marked = std::count(samples.begin(), samples.end(), std::uint8_t{1});
    return static_cast<double>(marked) / static_cast<double>(sample_count_);
  }

 private:
  /// Corner 0 and those from first to last.
  void addPiece(const Footprint& footprint, std::size_t first, std::size_t last)
  {
    const std::vector<Vector2>& corners = footprint.corners;
    std::vector<Plane> planes = {{0.0, 0.0, 1.0, -footprint.lowest},
                                 {0.0, 0.0, -1.0, footprint.highest}};
    planes.push_back(leftOf(corners[0], corners[first]));
    for (std::size_t i = first; i < last; ++i) {
      planes.push_back(leftOf(corners[i], corners[i + 1]));
    }
    planes.push_back(leftOf(corners[last], corners[0]));
    pieces_.push_back(std::move(planes));
  }

  void addSamples(const std::vector<Vector2>& corners)
  {
    Vector2 low = corners[0], high = corners[0];
    for (const Vector2& corner : corners) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        low[axis] = std::min(low[axis], corner[axis]);
        high[axis] = std::max(high[axis], corner[axis]);
      }
    }
    step_ = std::max(high[0] - low[0], high[1] - low[1]) / GROUND_SAMPLES;
    const auto rows = static_cast<std::size_t>(
        std::max(1.0, std::ceil((high[1] - low[1]) / step_ - 1e-9)));  // one of a thin footprint
    const double row_step = (high[1] - low[1]) / static_cast<double>(rows);
    for (std::size_t i = 0; i < rows; ++i) {
      const double y = low[1] + (static_cast<double>(i) + 0.5) * row_step;
      const std::array<double, 2> reach = reachAt(corners, y);
      const auto count =
          static_cast<std::size_t>(std::max(1.0, std::round((reach[1] - reach[0]) / step_)));
      const double middle = (reach[0] + reach[1]) / 2.0;
      rows_.push_back(
          {y, middle - 0.5 * step_ * static_cast<double>(count - 1), sample_count_, count});
      sample_count_ += count;
    }
  }

  struct Row
  {
    double y;
    double first_x;
    std::size_t begin, count;  // in the samples
  };
  std::vector<std::vector<Plane>> pieces_;
  std::vector<Row> rows_;
  std::size_t sample_count_ = 0;
  double step_ = 0.0;
};

/// The corners of a face, and of a part of it.
struct FaceCorners
{
  std::array<float, 9> floats;

  FaceCorners(const MeshView& mesh, std::uint32_t face)
  {
    for (std::size_t k = 0; k < 3; ++k) {
      std::copy_n(mesh.corner(face, k), 3, floats.data() + 3 * k);
    }
  }

  Vector3 operator[](std::size_t k) const { return pointOf(floats.data() + 3 * k); }
};

/// Calls body(region, planes, face) for the faces that touch the band of a footprint, piece by
/// piece, some more than once. A pose that is not finite has none.
template <class Body>
void forFacesUnder(const Bvh& bvh, const FootprintShape& shape, const RobotPose& pose,
                   const Body& body)
{
  for (const std::vector<Plane>& piece : shape.pieces()) {
    if (!pose.finite()) {
      return;
    }
    std::vector<Plane> planes;
    for (const Plane& plane : piece) {
      planes.push_back(pose.plane(plane));
    }
    const ConvexRegion region(planes);
    for (const std::uint32_t face : selectFaces(bvh, region)) {
      body(region, planes, face);
    }
  }
}

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
    forFacesUnder(bvh_, shape_, pose,
                  [&](const ConvexRegion& region, const std::vector<Plane>&, std::uint32_t face) {
                    add(index, pose, region, face);
                  });
    makeUnique(seen_);
    result_.face_counts[index] = static_cast<std::uint32_t>(seen_.size());
    result_.ground[index] = shape_.share(samples_);
  }

 private:
  void add(std::size_t index, const RobotPose& pose, const ConvexRegion& region, std::uint32_t face)
  {
    const FaceCorners corners(mesh_, face);
    std::array<float, 3> costs;
    for (std::size_t k = 0; k < 3; ++k) {
      costs[k] = costs_[mesh_.faces[3 * std::size_t{face} + k]];
    }
    seen_.push_back(face);
    const bool lethal =
        std::any_of(costs.begin(), costs.end(), [](float cost) { return std::isinf(cost); });
    const bool unknown =
        std::any_of(costs.begin(), costs.end(), [](float cost) { return std::isnan(cost); });
    result_.lethal[index] |= lethal ? 1 : 0;
    result_.unknown[index] |= unknown ? 1 : 0;

    ClippedTriangle part(corners.floats.data());
    part.cut(region.planes(), ALL_PLANES);
    const Vector3 u = corners[1] - corners[0], w = corners[2] - corners[0], n = cross(u, w);
    const bool has_area = dot(n, n) > 0.0;
    const float low = std::min({costs[0], costs[1], costs[2]});
    const float high = std::max({costs[0], costs[1], costs[2]});
    outline_.clear();
    double cost = has_area && !part.empty() ? low : high;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Vector3 local = pose.local(part[i]);
      outline_.push_back({local[0], local[1]});
      const auto [beta, gamma] = barycentricWeights(u, w, n, part[i] - corners[0]);
      // equation (4) of the paper
      const double here = (1.0 - beta - gamma) * costs[0] + beta * costs[1] + gamma * costs[2];
      cost = has_area ? std::max(cost, here) : cost;
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
  std::vector<std::uint8_t> samples_;
  std::vector<std::uint32_t> seen_;
  std::vector<Vector2> outline_;
};

}  // namespace

FootprintCosts footprintCosts(const Bvh& bvh, const MeshView& mesh, ArrayView<float> costs,
                              const Footprint& footprint, ArrayView<double> poses,
                              const BvhOptions& run_options)
{
  require(bvh.faceCount() == mesh.faceCount() && costs.size() == mesh.vertexCount() &&
              poses.size() % 12 == 0,
          "one cost per vertex and 12 numbers per pose are needed");
  const FootprintShape shape(footprint);
  const std::size_t count = poses.size() / 12;
  FootprintCosts result;
  result.max_costs.assign(count, 0.0f);
  result.lethal.assign(count, 0);
  result.unknown.assign(count, 0);
  result.ground.assign(count, 0.0);
  result.face_counts.assign(count, 0);

  Run run(run_options);
  run.each(count, CHUNK, 1.0,
           [&, query = FootprintQuery(bvh, mesh, costs, shape, result)](std::size_t i) mutable {
             run.check();
             query.ask(i, RobotPose(poses.data() + 12 * i));
           });
  run.finish();
  return result;
}

namespace {

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
    forFacesUnder(bvh_, shape_, pose,
                  [&](const ConvexRegion&, const std::vector<Plane>& planes, std::uint32_t face) {
                    add(planes, face);
                  });
    makeUnique(found_);
    return found_;
  }

 private:
  void add(const std::vector<Plane>& planes, std::uint32_t face)
  {
    const FaceCorners corners(mesh_, face);
    const std::uint32_t* const vertices = mesh_.faces.data() + 3 * std::size_t{face};
    const PlaneSides sides = planeSides(planes, ALL_PLANES, corners.floats.data());
    if (sides.outside == 0 && sides.cutting == 0) {
      found_.insert(found_.end(), vertices, vertices + 3);
      return;
    }
    ClippedTriangle part(corners.floats.data());
    part.cut(planes, sides.outside | sides.cutting);
    for (std::size_t k = 0; k < 3; ++k) {
      if (reaches(part, corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3])) {
        found_.push_back(vertices[k]);
      }
    }
  }

  /// Whether a point of the polygon is as near to one place as to two others: of what is as near as
  /// to the first, a corner is as near as to the second.
  static bool reaches(const ClippedTriangle& part, const Vector3& to, const Vector3& first,
                      const Vector3& second)
  {
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Vector3 &p = part[i], &q = part[i + 1 < part.size() ? i + 1 : 0];
      const Vector2 here = {nearness(p, to, first), nearness(p, to, second)};
      const Vector2 there = {nearness(q, to, first), nearness(q, to, second)};
      if (here[0] >= 0.0 && here[1] >= 0.0) {
        return true;
      }
      const double t = here[0] / (here[0] - there[0]);
      if ((here[0] < 0.0) != (there[0] < 0.0) && here[1] + t * (there[1] - here[1]) >= 0.0) {
        return true;
      }
    }
    return false;
  }

  const Bvh& bvh_;
  const MeshView& mesh_;
  const FootprintShape& shape_;
  std::vector<std::uint32_t> found_;
};

}  // namespace

FootprintVertices footprintVertices(const Bvh& bvh, const MeshView& mesh,
                                    const Footprint& footprint, ArrayView<double> poses,
                                    const BvhOptions& run_options)
{
  require(bvh.faceCount() == mesh.faceCount() && poses.size() % 12 == 0,
          "the hierarchy of the mesh and 12 numbers per pose are needed");
  const FootprintShape shape(footprint);
  std::vector<std::vector<std::uint32_t>> rows(poses.size() / 12);
  Run run(run_options);
  run.each(rows.size(), CHUNK, 1.0,
           [&, query = VerticesQuery(bvh, mesh, shape)](std::size_t i) mutable {
             run.check();
             rows[i] = query.under(RobotPose(poses.data() + 12 * i));
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
