#include "navigation/remaining_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace rviz_mesh_plugin {
namespace {

/// Over which the speed is averaged, and from how many of them on.
constexpr std::chrono::seconds SPEED_PERIOD(8), LEAST_PERIOD(1);
constexpr double STANDS = 0.02;  // m/s: slower is no speed to foretell by
/// So far ahead along the path the robot is looked for first: a path may come back to a place.
constexpr double LOOK_AHEAD = 3.0;  // meters
/// Farther than this from what is ahead, it may be anywhere on the path.
constexpr double OFF_PATH = 1.0;  // meters

double distance(const RemainingPath::Point& a, const RemainingPath::Point& b)
{
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                   (a[2] - b[2]) * (a[2] - b[2]));
}

/// The share of the piece from a to b at which it is nearest to p.
double nearestShare(const RemainingPath::Point& a, const RemainingPath::Point& b,
                    const RemainingPath::Point& p)
{
  double along = 0.0, square = 0.0;
  for (unsigned i = 0; i < 3; ++i) {
    along += (p[i] - a[i]) * (b[i] - a[i]);
    square += (b[i] - a[i]) * (b[i] - a[i]);
  }
  return square > 0.0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
}

}  // namespace

void RemainingPath::setPath(const std::string& frame, std::vector<Point> points)
{
  frame_ = frame;
  points_ = std::move(points);
  passed_ = 0;
  length_.reset();
  lengths_.assign(points_.size(), 0.0);
  for (std::size_t i = points_.size(); i-- > 1;) {
    lengths_[i - 1] = lengths_[i] + distance(points_[i - 1], points_[i]);
  }
  reached_ = points_.empty() ? 0.0 : lengths_[0];
  if (!steps_.empty() && robot_frame_ == frame_) {
    follow(steps_.back().position);
  }
}

void RemainingPath::takePosition(const std::string& frame, const Point& position, Time now)
{
  if (frame != robot_frame_ || (!steps_.empty() && now < steps_.back().time)) {
    steps_.clear();
    robot_frame_ = frame;
  }
  const double so_far =
      steps_.empty() ? 0.0 : steps_.back().distance + distance(steps_.back().position, position);
  if (!std::isfinite(so_far + position[0] + position[1] + position[2])) {
    return;
  }
  steps_.push_back({now, so_far, position});
  while (now - steps_.front().time > SPEED_PERIOD) {
    steps_.pop_front();
  }
  length_.reset();
  if (frame == frame_) {
    follow(position);
  }
}

void RemainingPath::follow(const Point& position)
{
  if (points_.empty() || !std::isfinite(lengths_[0])) {
    return;
  }
  if (points_.size() == 1) {
    length_ = distance(position, points_[0]);
    return;
  }
  double least = std::numeric_limits<double>::infinity();
  std::size_t nearest = passed_;
  double share = 0.0;
  const auto look = [&](std::size_t from, double until) {
    for (std::size_t i = from; i + 1 < points_.size() && lengths_[i] >= until; ++i) {
      const double t = nearestShare(points_[i], points_[i + 1], position);
      Point on_path;
      for (unsigned k = 0; k < 3; ++k) {
        on_path[k] = points_[i][k] + t * (points_[i + 1][k] - points_[i][k]);
      }
      const double from_robot = distance(position, on_path);
      if (from_robot < least) {
        least = from_robot;
        nearest = i;
        share = t;
      }
    }
  };
  look(passed_, reached_ - LOOK_AHEAD);
  if (least > OFF_PATH) {
    look(0, 0.0);
  }
  passed_ = nearest;
  reached_ = lengths_[nearest] - share * (lengths_[nearest] - lengths_[nearest + 1]);
  length_ = reached_;
}

std::optional<double> RemainingPath::timeFor(double meters) const
{
  if (steps_.size() < 2 || steps_.back().time - steps_.front().time < LEAST_PERIOD) {
    return std::nullopt;
  }
  const std::chrono::duration<double> period = steps_.back().time - steps_.front().time;
  const double speed = (steps_.back().distance - steps_.front().distance) / period.count();
  return speed > STANDS ? std::make_optional(meters / speed) : std::nullopt;
}

}  // namespace rviz_mesh_plugin
