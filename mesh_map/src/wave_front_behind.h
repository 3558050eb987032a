#ifndef MESH_MAP_SRC_WAVE_FRONT_BEHIND_H
#define MESH_MAP_SRC_WAVE_FRONT_BEHIND_H

#include <algorithm>
#include <cmath>

#include "wave_front_triangle.h"

namespace mesh_map {

/// The third corner of the face on the other side of a base, laid into the plane of
/// WaveFrontTriangle at (along, -depth), and its label.
struct WaveFrontBehind
{
  double along, depth, label;
};

/// The same as roundFront(), seen from one face further back: where the way has come into that face
/// through another of its sides, the source follows from the labels at the ends of that side, and
/// the way crosses both. On bent surfaces this is about twice as exact: between two labels the
/// front is never quite a circle, and one side less is crossed. Not more than `plain`, what
/// roundFront() gives; that where the ways contradict each other.
inline double roundFrontFromBehind(double u, double v, const WaveFrontTriangle& triangle,
                                   const WaveFrontBehind& behind, double plain)
{
  const double base = triangle.base, along = triangle.along, height = triangle.height;
  const double sx = 0.5 * (base * base + (u - v) * (u + v)) / base;
  const double sy = std::sqrt(std::max(0.0, (u - sx) * (u + sx)));
  // On which side of the way from the source to the corner is the third corner of the face behind?
  const double way_x = along - sx, way_y = height + sy;
  const double side = way_x * (sy - behind.depth) - way_y * (behind.along - sx);
  const bool is_near_u = side < 0.0;  // then the way comes through the side from the origin to it
  const double from = is_near_u ? 0.0 : base, label = is_near_u ? u : v;
  const double x = behind.along - from, y = -behind.depth;
  const double length = std::sqrt(x * x + y * y);
  const double foot =
      0.5 * (length * length + (label - behind.label) * (label + behind.label)) / length;
  const double squared = (label - foot) * (label + foot);
  if (!(squared >= 0.0)) {
    return plain;
  }
  // The source is on the side of it that the other end of the base is not.
  const double off = std::sqrt(squared) / length * (is_near_u ? 1.0 : -1.0);
  const double part = foot / length;
  const double source_x = from + part * x + off * y, source_y = part * y - off * x;
  const double to_x = along - source_x, to_y = height - source_y;
  const double at_base = source_x * height - along * source_y;  // times to_y: where it crosses
  const double start = to_x * (0.0 - source_y) - to_y * (from - source_x);
  const double end = to_x * (y - source_y) - to_y * (behind.along - source_x);
  if (!(source_y <= 0.0 && at_base >= 0.0 && at_base <= base * to_y) || start * end > 0.0) {
    return plain;
  }
  return std::min(plain, std::sqrt(to_x * to_x + to_y * to_y));
}

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_WAVE_FRONT_BEHIND_H
