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

  WaveFrontBehind scaled(double by) const { return {by * along, by * depth, label}; }
};

/// Is the front earlier there than the source says? Else nothing that comes across the sides of the
/// face behind is earlier than what comes from the source.
inline bool isEarlier(const WaveFrontBehind& behind, const WaveFrontSource& source)
{
  const double x = behind.along - source.along, y = behind.depth - source.depth;
  return behind.label * behind.label < x * x + y * y;
}

/// The same as roundFront(), seen from one face further back: where the way comes into that face
/// through another of its sides, a source follows from the labels at the ends of that side, too,
/// and the way from there may be shorter. On bent surfaces that is twice as exact: between two
/// labels a front is never quite a circle, and one side less is crossed. Infinite where the way
/// does not cross both sides.
inline double roundFrontFromBehind(double u, double v, const WaveFrontTriangle& triangle,
                                   const WaveFrontSource& source, const WaveFrontBehind& behind)
{
  // On which side of the way from the source to the corner is the third corner of the face behind?
  const double left = (triangle.along - source.along) * (source.depth - behind.depth);
  const double right = (triangle.height + source.depth) * (behind.along - source.along);
  const bool is_near_u = left < right;  // then the way comes through the side at the origin
  const double from = is_near_u ? 0.0 : triangle.base, label = is_near_u ? u : v;
  const double x = behind.along - from, y = -behind.depth;
  const double squared = x * x + y * y;
  // As parts of that side: where the new source is along it, and how far off, squared.
  const double part = 0.5 * (1.0 + (label - behind.label) * (label + behind.label) / squared);
  const double off_squared = label * label / squared - part * part;
  if (!(off_squared >= 0.0)) {
    return NOT_REACHED;
  }
  // It is on the side that the other end of the base is not.
  const double off = is_near_u ? std::sqrt(off_squared) : -std::sqrt(off_squared);
  const double source_x = from + part * x + off * y, source_y = part * y - off * x;
  const double way_x = triangle.along - source_x, way_y = triangle.height - source_y;
  const double at_base = source_x * triangle.height - triangle.along * source_y;
  const double at_end = way_x * -source_y - way_y * (from - source_x);
  const double at_behind = way_x * (y - source_y) - way_y * (behind.along - source_x);
  const bool crosses = source_y <= 0.0 && at_base >= 0.0 && at_base <= triangle.base * way_y &&
                       at_end * at_behind <= 0.0;
  return crosses ? std::sqrt(way_x * way_x + way_y * way_y) : NOT_REACHED;
}

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_WAVE_FRONT_BEHIND_H
