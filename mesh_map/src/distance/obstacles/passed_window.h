#pragma once

#include <array>
#include <vector>

#include "distance/obstacles/window.h"

namespace mesh_map {

/// Distances of a window along its edge, from 0 at the end with the smaller index to 1.
struct PassedWindow
{
  bool is_strip;
  double offset;
  Vector2 start, side;
  std::array<double, 2> range;  // where it is better than what came before

  explicit PassedWindow(const Window& window);
  /// The distance, and by how much it grows along the whole edge.
  std::array<double, 2> rise(double at) const;
  /// Is it shorter everywhere between two places?
  bool isBetter(const PassedWindow& other, double begin, double end) const;
};

/// Cuts what other windows at the edge are shorter than off both ends of a window, and adds what is
/// left to them. False where that is nothing.
bool cutBehind(std::vector<PassedWindow>& passed, Window& window);

}  // namespace mesh_map
