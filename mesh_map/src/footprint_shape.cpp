#include "footprint_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace mesh_map {
namespace {

/// Corners of a piece: its sides and the two ends of the band are planes.
constexpr std::size_t MOST_CORNERS = ConvexRegion::MAX_PLANES - 2;

Plane leftOf(const Point2& from, const Point2& to)
{
  const double a = from[1] - to[1], b = to[0] - from[0];
  return {a, b, 0.0, -(a * from[0] + b * from[1])};
}

/// From where to where a convex polygon reaches at a height; empty (from > to) where it does not.
std::array<double, 2> reachAt(const std::vector<Point2>& polygon, double y)
{
  std::array<double, 2> reach{std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    if (std::min(p[1], q[1]) > y || std::max(p[1], q[1]) < y) {
      continue;
    }
    for (const Point2* end : {&p, &q}) {
      const double x = p[1] == q[1] ? (*end)[0] : p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
      reach = {std::min(reach[0], x), std::max(reach[1], x)};
    }
  }
  return reach;
}

}  // namespace

RobotPose::RobotPose(const double* numbers)
{
  for (std::size_t i = 0; i < 3; ++i) {
    rows_[i] = {numbers[4 * i], numbers[4 * i + 1], numbers[4 * i + 2]};
    shift_[i] = numbers[4 * i + 3];
    finite_ = finite_ && isFinite(rows_[i]) && std::isfinite(shift_[i]);
  }
}

Plane RobotPose::plane(const Plane& robot) const
{
  const Vector3 normal{robot[0], robot[1], robot[2]};
  const Vector3 turned{dot(rows_[0], normal), dot(rows_[1], normal), dot(rows_[2], normal)};
  return {turned[0], turned[1], turned[2], robot[3] - dot(turned, shift_)};
}

Vector3 RobotPose::local(const Vector3& point) const
{
  const Vector3 gap = point - shift_;
  Vector3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      result[k] += gap[i] * rows_[i][k];
    }
  }
  return result;
}

FootprintShape::FootprintShape(const Footprint& footprint)
{
  const std::vector<Point2>& corners = footprint.corners;
  const std::size_t count = corners.size();
  bool convex = count >= 3 && footprint.lowest <= footprint.highest;
  double turned = 0.0;
  for (std::size_t i = 0; convex && i < count; ++i) {
    const Point2 &p = corners[i], &q = corners[(i + 1) % count], &r = corners[(i + 2) % count];
    const double x = q[0] - p[0], y = q[1] - p[1], next_x = r[0] - q[0], next_y = r[1] - q[1];
    const double cross = x * next_y - y * next_x;
    convex = std::isfinite(cross) && cross >= 0.0 && (x != 0.0 || y != 0.0);
    turned += std::atan2(cross, x * next_x + y * next_y);
  }
  if (!convex || std::abs(turned - 2.0 * 3.14159265358979323846) > 1e-3) {
    throw std::invalid_argument(
        "the footprint has to be convex and counter-clockwise, with a band"
        " from its lowest to its highest z");
  }
  for (std::size_t first = 1; first + 1 < count; first += MOST_CORNERS - 2) {
    addPiece(footprint, first, std::min(count - 1, first + MOST_CORNERS - 2));
  }
  addSamples(corners);
}

/// Corner 0 and those from first to last.
void FootprintShape::addPiece(const Footprint& footprint, std::size_t first, std::size_t last)
{
  const std::vector<Point2>& corners = footprint.corners;
  std::vector<Plane> planes = {{0.0, 0.0, 1.0, -footprint.lowest},
                               {0.0, 0.0, -1.0, footprint.highest}};
  planes.push_back(leftOf(corners[0], corners[first]));
  for (std::size_t i = first; i < last; ++i) {
    planes.push_back(leftOf(corners[i], corners[i + 1]));
  }
  planes.push_back(leftOf(corners[last], corners[0]));
  pieces_.push_back(std::move(planes));
}

void FootprintShape::addSamples(const std::vector<Point2>& corners)
{
  Point2 low = corners[0], high = corners[0];
  for (const Point2& corner : corners) {
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

void FootprintShape::mark(const std::vector<Point2>& polygon,
                          std::vector<std::uint8_t>& samples) const
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

double FootprintShape::share(const std::vector<std::uint8_t>& samples) const
{
  const auto marked = std::count(samples.begin(), samples.end(), std::uint8_t{1});
  return static_cast<double>(marked) / static_cast<double>(sample_count_);
}

}  // namespace mesh_map
