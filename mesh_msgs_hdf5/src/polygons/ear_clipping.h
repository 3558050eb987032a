#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_msgs_hdf5 {
struct Point
{
  double x;
  double y;
};

inline bool operator==(const Point& p, const Point& q)
{
  return p.x == q.x && p.y == q.y;
}

/// Whether c is left (> 0) or right (< 0) of the way from a to b, or on it (0); the size is twice
/// the area of the triangle.
double turn(const Point& a, const Point& b, const Point& c);

/// Whether two edges of the polygon cross within both; those that only touch do not. steps: how
/// many pairs of edges may be looked at, of which it takes off what it needs.
bool crossesItself(const std::vector<Point>& polygon, std::int64_t& steps);

using Corners = std::array<std::int64_t, 3>;

/// Cuts a polygon into triangles by ear clipping, the best shaped ear first.
///
/// The polygon goes around its inside counterclockwise. Its edges may touch and lie upon each other
/// (holes at bridges), corners may come twice or lie on a line; then some triangles may have no
/// area. It makes always n - 2 triangles, whatever the points are, and ends after a number of steps
/// that grows with the square of n.
class EarClipping
{
 public:
  /// steps: how often corners may be compared with triangles; beyond it ears are taken unseen.
  EarClipping(const std::vector<Point>& polygon, std::int64_t& steps);

  /// Appends the corners of n - 2 triangles, in the polygon's sense of rotation. False if some lie
  /// outside or upon each other: the polygon crosses itself, or there were too many steps.
  bool run(std::vector<Corners>& triangles);

 private:
  enum class Ear
  {
    FREE,
    TOUCHED,  ///< a corner lies on the side that it would leave behind
    BLOCKED
  };
  struct Candidate
  {
    double quality;
    std::size_t corner;
    std::uint32_t version;
    bool operator<(const Candidate& other) const { return quality < other.quality; }
  };

  double turnAt(std::size_t corner) const;
  bool isSpike(std::size_t corner) const;
  double quality(std::size_t corner) const;
  Ear look(std::size_t corner);
  bool enters(const std::array<Point, 3>& ear, const std::array<double, 3>& sides,
              std::size_t to) const;
  void offer(std::size_t corner);
  void clip(std::size_t corner, std::vector<Corners>& triangles);
  std::size_t nextBest();

  const std::vector<Point>& points_;
  std::int64_t& steps_;
  std::vector<std::size_t> before_;
  std::vector<std::size_t> behind_;
  std::vector<std::uint32_t> versions_;
  std::vector<Candidate> heap_;
  std::size_t left_;
  std::size_t any_ = 0;  ///< a corner that is still there
  bool sound_ = true;
};

}  // namespace mesh_msgs_hdf5
