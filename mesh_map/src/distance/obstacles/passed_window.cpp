#include "distance/obstacles/passed_window.h"

#include <algorithm>
#include <cmath>

namespace mesh_map {
namespace {

/// How much longer (by this part) a window has to be than another one to count as longer.
constexpr double WORSE = 1e-9;

/// A part of an edge, where one window ends and another one gets better, is halved this often.
constexpr unsigned MOST_HALVES = 4;

}  // namespace

PassedWindow::PassedWindow(const Window& window) : is_strip(window.is_strip), offset(window.offset)
{
  const bool is_upward = window.right < window.left;
  start = is_upward ? window.right_end : window.left_end;
  side = (is_upward ? window.left_end : window.right_end) - start;
  const Doubles2 along = window.range();
  range = is_upward ? std::array<double, 2>{along[0], along[1]}
                    : std::array<double, 2>{1.0 - along[1], 1.0 - along[0]};
}

std::array<double, 2> PassedWindow::rise(double at) const
{
  const Vector2 p = start + at * side;
  const double length = is_strip ? p[1] : norm(p);
  const double slope = is_strip ? side[1] : length > 0.0 ? dot(p, side) / length : 0.0;
  return {offset + length, slope};
}

/// Distances are convex along an edge: they lie below their chord, and above their tangents.
bool PassedWindow::isBetter(const PassedWindow& other, double begin, double end) const
{
  if (!(begin < end)) {
    return false;
  }
  const double width = end - begin, at_begin = rise(begin)[0], at_end = rise(end)[0];
  const double slope = (at_end - at_begin) / width;
  const auto [first, up] = other.rise(begin);
  const auto [last, down] = other.rise(end);
  const double margin = WORSE * std::max(first, last);
  const double left = first - at_begin, right = last - at_end;
  double least = std::min(left, right);
  // Where the two tangents meet.
  if (down > up) {
    const double meet = std::min(width, std::max(0.0, (first - last + down * width) / (down - up)));
    least = std::min(least,
                     std::max(left + (up - slope) * meet, right - (down - slope) * (width - meet)));
  }
  return least > margin;
}

bool cutBehind(std::vector<PassedWindow>& passed, Window& window)
{
  PassedWindow own(window);
  const auto before = own.range;
  const auto advance = [&own](const PassedWindow& other) {
    double end = std::min(own.range[1], other.range[1]);
    for (unsigned halves = 0; halves < MOST_HALVES; ++halves) {
      if (other.range[0] <= own.range[0] && other.isBetter(own, own.range[0], end)) {
        own.range[0] = end;
        return true;
      }
      end = 0.5 * (own.range[0] + end);
    }
    return false;
  };
  const auto retreat = [&own](const PassedWindow& other) {
    double begin = std::max(own.range[0], other.range[0]);
    for (unsigned halves = 0; halves < MOST_HALVES; ++halves) {
      if (other.range[1] >= own.range[1] && other.isBetter(own, begin, own.range[1])) {
        own.range[1] = begin;
        return true;
      }
      begin = 0.5 * (begin + own.range[1]);
    }
    return false;
  };
  for (bool is_shorter = true; is_shorter;) {
    is_shorter = false;
    for (const PassedWindow& other : passed) {
      is_shorter = advance(other) || is_shorter;
      is_shorter = (own.range[0] < own.range[1] && retreat(other)) || is_shorter;
      if (!(own.range[0] < own.range[1])) {
        return false;
      }
    }
  }
  const bool is_upward = window.right < window.left;
  const auto limit = [&](double at) { return window.rayTo(own.start + at * own.side); };
  if (own.range[0] > before[0]) {
    (is_upward ? window.right_ray : window.left_ray) = limit(own.range[0]);
  }
  if (own.range[1] < before[1]) {
    (is_upward ? window.left_ray : window.right_ray) = limit(own.range[1]);
  }
  passed.push_back(own);
  return true;
}

}  // namespace mesh_map
