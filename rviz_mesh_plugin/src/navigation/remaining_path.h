#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// How far a robot still has to go along its path, and how long that takes at the speed that it has
/// had of late.
class RemainingPath
{
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Point = std::array<double, 3>;

  /// Another path; the speed stays known.
  void setPath(const std::string& frame, std::vector<Point> points);

  /// The robot is here.
  void takePosition(const std::string& frame, const Point& position, Time now);

  /// Along the path from the point that is nearest to the robot, in meters; nothing without a path
  /// in the frame of the robot's position.
  const std::optional<double>& length() const { return length_; }

  /// For so many meters, in seconds; nothing for a robot that stands, or has just begun.
  std::optional<double> timeFor(double meters) const;

  /// Everything.
  void clear() { *this = RemainingPath(); }

 private:
  struct Step
  {
    Time time;
    double distance;  ///< since the first one, in meters
    Point position;
  };
  void follow(const Point& position);

  std::string frame_;
  std::vector<Point> points_;
  std::vector<double> lengths_;  ///< from each point to the end, in meters
  std::size_t passed_ = 0;       ///< the piece that the robot is on begins there
  double reached_ = 0.0;         ///< from where the robot was last to the end, in meters
  std::optional<double> length_;
  std::string robot_frame_;
  std::deque<Step> steps_;  ///< of the last seconds
};

}  // namespace rviz_mesh_plugin
