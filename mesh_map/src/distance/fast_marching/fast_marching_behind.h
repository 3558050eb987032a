#pragma once

#include <algorithm>
#include <cmath>

#include "distance/fast_marching/fast_marching_triangle.h"

namespace mesh_map {

/// The third corner of the face on the other side of a base, laid into the plane of
/// FastMarchingTriangle at (along, -depth), and its label.
struct FastMarchingBehind
{
  double along, depth, label;

  FastMarchingBehind scaled(double by) const { return {by * along, by * depth, label}; }
};

/// Of a squared distance: what is earlier by less is as early.
constexpr double AS_EARLY = 1e-10;

/// Is the front earlier there than the source says? Else nothing that comes across the sides of the
/// face behind is earlier than what comes from the source.
inline bool isEarlier(const FastMarchingBehind& behind, const FastMarchingSource& source)
{
  const double x = behind.along - source.along, y = behind.depth - source.depth;
  return behind.label * behind.label < (x * x + y * y) * (1.0 - AS_EARLY);
}

/// The same of labels u, v at the ends of the base and `label` behind it, by squares: of the base,
/// of the side from u to what is behind, their scalar product, and the squared area between (of
/// the parallelogram). May be true where what is behind is just as early.
[[gnu::always_inline]] inline bool mayBeEarlier(double label, double u, double v, double base,
                                                double side, double product, double area)
{
  // (x - x_s)^2 + (y - y_s)^2 > label^2, with y_s from u^2 = x_s^2 + y_s^2; all times the base.
  const double foot = 0.5 * (base + (u - v) * (u + v));
  const double off_squared = u * u * base - foot * foot;
  const double more = (side + (u - label) * (u + label) - 0.9 * AS_EARLY * label * label) * base -
                      2.0 * product * foot;
  return !(off_squared >= 0.0) || (more > 0.0 && more * more > 4.0 * area * off_squared);
}

/// The shortest way to the corner of a triangle from the side between the origin, where the label
/// is u, and what is behind: from the source that follows from these two labels, straight where it
/// crosses both that side and the base. Else by way of what is behind, or past the far end of the
/// base: so what follows is as continuous, and monotone in the labels, as shortest ways are.
/// Infinite where it passes the origin, as a way along the edge from there does, too.
inline double updateFromSide(double u, const FastMarchingTriangle& triangle,
                             const FastMarchingBehind& behind)
{
  const double base = triangle.base, height = triangle.height;
  const double x = behind.along, depth = behind.depth, squared = x * x + depth * depth;
  const double at_base = x * height + triangle.along * depth;  // the way from what is behind
  if (!(at_base > 0.0 && squared > 0.0)) {
    return NOT_REACHED;
  }
  // As parts of the side: where the source is along it, and how far off, squared.
  double part = 0.5 * (1.0 + (u - behind.label) * (u + behind.label) / squared);
  const double off_squared = u * u / squared - part * part;
  if (off_squared < 0.0 && part <= 0.0) {
    return NOT_REACHED;
  }
  bool passes_behind = off_squared < 0.0 && part >= 1.0;
  const bool is_line = off_squared < 0.0 && isSourceLine(u, behind.label, std::sqrt(squared));
  if (is_line) {
    const double length = std::sqrt(squared);
    const FastMarchingSourceLine line(u, behind.label, length);
    part = line.nearestTo((triangle.along * x - height * depth) / length) / length;
  }
  if (!passes_behind) {
    const double off = std::sqrt(std::max(0.0, off_squared));
    // It is on the side that the other end of the base is not.
    const double source_x = part * x - off * depth, source_y = -part * depth - off * x;
    const double way_x = triangle.along - source_x, way_y = height - source_y;
    const double crossing = source_x * height - triangle.along * source_y;
    if (crossing < 0.0) {
      return NOT_REACHED;
    }
    passes_behind = way_x * (-depth - source_y) > way_y * (x - source_x);
    if (!passes_behind && crossing <= base * way_y) {
      return std::sqrt(way_x * way_x + way_y * way_y);
    }
  }
  if (passes_behind && at_base <= base * (height + depth)) {
    const double way_x = triangle.along - x, way_y = height + depth;
    return behind.label + std::sqrt(way_x * way_x + way_y * way_y);
  }
  // From where the line past the far end of the base meets the side.
  const double meets = base * height / (x * height + (triangle.along - base) * depth);
  if (!(meets >= 0.0 && meets <= 1.0)) {
    return NOT_REACHED;
  }
  const double from =
      is_line
          ? std::max(0.0, u - meets * std::sqrt(squared))
          : std::sqrt(std::max(0.0, u * u * (1.0 - meets) + behind.label * behind.label * meets -
                                        squared * meets * (1.0 - meets)));
  const double way_x = triangle.along - meets * x, way_y = height + meets * depth;
  return from + std::sqrt(way_x * way_x + way_y * way_y);
}

/// What comes across the base from the sides of the face behind it. On bent surfaces that is twice
/// as exact as what follows from the labels of the base: between two labels a front is never quite
/// a circle, and one side less is crossed.
[[gnu::noinline]] inline double updateFromBehind(double u, double v,
                                                 const FastMarchingTriangle& triangle,
                                                 const FastMarchingBehind& behind)
{
  const FastMarchingTriangle mirrored = {triangle.base, triangle.base - triangle.along,
                                         triangle.height, 0.0};
  return std::min(
      updateFromSide(u, triangle, behind),
      updateFromSide(v, mirrored, {triangle.base - behind.along, behind.depth, behind.label}));
}

/// May a label be above what is on the base or the sides of the face behind it?
[[gnu::always_inline]] inline bool mayLowerAcross(double label, double u, double v,
                                                  const FastMarchingTriangle& triangle,
                                                  const FastMarchingBehind& behind)
{
  const double squared = behind.depth * behind.depth, x = behind.along, y = triangle.base - x;
  const double longest = std::max(triangle.base * triangle.base, squared + std::max(x * x, y * y));
  const double first = std::min(std::min(u, v), behind.label);
  return label > 0.0 && label * label > first * first - 0.25 * longest;
}

/// The update where all is equally slow: from the source that the labels of the base tell, and from
/// the sides of the face behind where the front has been earlier there. Infinite, too, where that
/// is clearly not below `label`.
[[gnu::always_inline]] inline double evenUpdate(double u, double v,
                                                const FastMarchingTriangle& triangle,
                                                const FastMarchingBehind& behind,
                                                double label = NOT_REACHED)
{
  if (!(triangle.base > 0.0) || !mayLowerAcross(label - triangle.height, u, v, triangle, behind)) {
    return NOT_REACHED;
  }
  // What is later by more than the base is long gets a front along it.
  u = std::min(u, v + triangle.base);
  v = std::min(v, u + triangle.base);
  double plain;
  if (!isSourceLine(u, v, triangle.base)) {
    FastMarchingSource source;
    findSource(u, v, triangle.base, source);
    plain = sphericalUpdate(u, source, triangle);
    if (!(behind.label < NOT_REACHED && isEarlier(behind, source))) {
      return plain;
    }
  } else {
    const FastMarchingSourceLine line(u, v, triangle.base);
    const double off = triangle.along - line.nearestTo(triangle.along);
    plain = std::sqrt(off * off + triangle.height * triangle.height);
    if (!(behind.label < NOT_REACHED)) {
      return plain;
    }
  }
  return std::min(plain, updateFromBehind(u, v, triangle, behind));
}

}  // namespace mesh_map
