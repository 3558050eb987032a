#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace mesh_map {

constexpr double NOT_REACHED = std::numeric_limits<double>::infinity();

/// A source on the base itself may seem to be none by this part of the squared base, by rounding.
constexpr double ON_BASE = 1e-9;

/// The third corner of a triangle as its base sees it: the base runs from the origin along the x
/// axis to (base, 0), the corner is at (along, height), `squared` its squared distance from the
/// origin.
struct FastMarchingTriangle
{
  double base, along, height, squared;

  FastMarchingTriangle scaled(double by) const
  {
    return {by * base, by * along, by * height, by * by * squared};
  }
};

/// May a front through a base with these labels at its ends lower a label beyond it? All that
/// crosses the base is as far at least as the nearest point of the base, and between two labels at
/// a distance c, u^2 (1 - t) + v^2 t - c^2 t (1 - t) is the square of the distance at the part t
/// (theorem of Stewart).
inline bool mayLower(double label, double u, double v, double base)
{
  const double nearer = u < v ? u : v;
  return label * label > nearer * nearer - 0.25 * base * base;
}

/// How far along a base the point is that has these distances from its ends (law of cosines).
inline double footOfSource(double u, double v, double base)
{
  return 0.5 * (base * base + (u - v) * (u + v)) / base;
}

/// The least distance on a base with these labels at its ends.
inline double leastOnBase(double u, double v, double base)
{
  const double nearer = u < v ? u : v, foot = footOfSource(u, v, base);
  return foot > 0.0 && foot < base ? std::sqrt(std::max(0.0, (u - foot) * (u + foot))) : nearer;
}

/// Where a front comes from that has these labels at the ends of a base, when all that is between
/// is unfolded: (along, -depth) in the plane of FastMarchingTriangle.
struct FastMarchingSource
{
  double along, depth;

  /// How far along the base (times depth + height) the straight way to a corner at (x, height)
  /// crosses it, and whether it does at all.
  double crossing(double x, double height) const { return along * height + x * depth; }
  bool crosses(double base, double x, double height) const
  {
    const double place = crossing(x, height);
    return place >= 0.0 && place <= base * (depth + height);
  }
};

/// False where no point has these distances from the ends. (M. Novotni, R. Klein: Computing
/// Geodesic Distances on Triangular Meshes, 2002.)
inline bool findSource(double u, double v, double base, FastMarchingSource& source)
{
  const double along = footOfSource(u, v, base);
  const double squared = (u - along) * (u + along);
  source = {along, std::sqrt(std::max(0.0, squared))};
  return squared >= -ON_BASE * base * base;
}

/// The update of fast marching for the eikonal equation |grad T| F = 1 (J. A. Sethian, 1996) in a
/// triangle (R. Kimmel, J. A. Sethian: Computing Geodesic Paths on Manifolds, 1998), of a round
/// front: the distance of the corner from the source, which is u away from the origin. Infinite
/// where the way does not cross the base. Where the corner is nearer than the origin, `more` is
/// negative.
inline double sphericalUpdate(double u, const FastMarchingSource& source,
                              const FastMarchingTriangle& triangle)
{
  if (!source.crosses(triangle.base, triangle.along, triangle.height)) {
    return NOT_REACHED;
  }
  // sqrt(u * u + more), without losing what u and the result differ by.
  const double more =
      triangle.squared + 2.0 * (source.depth * triangle.height - source.along * triangle.along);
  const double sum = u + std::sqrt(std::max(0.0, u * u + more));
  return sum > 0.0 ? u + more / sum : 0.0;
}

/// Slowness at the ends of the base, and at the corner.
struct FastMarchingSlowness
{
  double u, v, corner;

  double onBase() const { return 0.5 * (u + v); }
  /// The mean along a straight line from the part t of the base to the corner.
  double acrossFrom(double t) const { return 0.5 * (u + (v - u) * t + corner); }
};

/// The same as sphericalUpdate() with costs that change a little: as far as to the base, all is as
/// slow as the base is; beyond, as the face is along the way. `low` is the least slowness; infinite
/// where it is clear from that alone that the result is not below `label`.
inline double nearlySphericalUpdate(double u, double v, const FastMarchingTriangle& triangle,
                                    const FastMarchingSlowness& slowness, double low, double label)
{
  const double scale = slowness.onBase();
  const FastMarchingTriangle scaled = triangle.scaled(scale);
  FastMarchingSource source;
  if (!findSource(u, v, scaled.base, source)) {
    return NOT_REACHED;
  }
  const double way = sphericalUpdate(u, source, scaled), depth = source.depth + scaled.height;
  if (!(way < NOT_REACHED && way * low < label * scale && depth > 0.0)) {
    return NOT_REACHED;
  }
  const double crossing = source.crossing(scaled.along, scaled.height);
  const double beyond = slowness.acrossFrom(crossing / (scaled.base * depth));
  return way * (source.depth * scale + scaled.height * beyond) / (depth * scale);
}

/// With costs that change within the faces: the least way over points of the base (F. Bornemann,
/// C. Rasch: Finite-Element Discretization of Static Hamilton-Jacobi Equations Based on a Local
/// Variational Principle, 2006). With `curve` 0,
/// labels are linear in between: a front that bends may look as if its source were right behind
/// the base. Else they are distances from a source, and `curve` is the time along the base.
/// Infinite where that is not below `label`; `low` is the least slowness.
inline double unevenUpdate(double u, double v, const FastMarchingTriangle& triangle,
                           const FastMarchingSlowness& slowness, double low, double curve,
                           double label)
{
  constexpr int PARTS = 4;
  const double beyond = label - low * triangle.height;
  if (beyond <= 0.0 || !mayLower(beyond, u, v, curve)) {
    return NOT_REACHED;
  }
  const auto label_through = [&](double t) {
    const double squared = u * u * (1.0 - t) + v * v * t - curve * curve * t * (1.0 - t);
    const double x = triangle.along - t * triangle.base;
    return (curve > 0.0 ? std::sqrt(std::max(0.0, squared)) : u + (v - u) * t) +
           slowness.acrossFrom(t) * std::sqrt(x * x + triangle.height * triangle.height);
  };
  double ways[PARTS + 1];
  for (int i = 0; i <= PARTS; ++i) {
    ways[i] = label_through(i * (1.0 / PARTS));
  }
  int least = 1;
  for (int i = 2; i < PARTS; ++i) {
    least = ways[i] < ways[least] ? i : least;
  }
  // Between the points, the lowest of a parabola.
  const double before = ways[least - 1], after = ways[least + 1];
  const double bend = before - 2.0 * ways[least] + after;
  if (!(bend > 0.0)) {
    return ways[least];
  }
  const double step = std::min(1.0, std::max(-1.0, 0.5 * (before - after) / bend));
  return std::min(ways[least], label_through((least + step) * (1.0 / PARTS)));
}

/// The third corner of the face on the other side of a base, laid into the plane of
/// FastMarchingTriangle at (along, -depth), and its label.
struct FastMarchingBehind
{
  double along, depth, label;

  FastMarchingBehind scaled(double by) const { return {by * along, by * depth, label}; }
};

/// Is the front earlier there than the source says? Else nothing that comes across the sides of the
/// face behind is earlier than what comes from the source.
inline bool isEarlier(const FastMarchingBehind& behind, const FastMarchingSource& source)
{
  const double x = behind.along - source.along, y = behind.depth - source.depth;
  return behind.label * behind.label < x * x + y * y;
}

/// The same as sphericalUpdate(), seen from one face further back: where the way comes into that
/// face through another of its sides, a source follows from the labels at the ends of that side,
/// too, and the way from there may be shorter. On bent surfaces that is twice as exact: between two
/// labels a front is never quite a circle, and one side less is crossed. Infinite where the way
/// does not cross both sides.
inline double sphericalUpdateFromBehind(double u, double v, const FastMarchingTriangle& triangle,
                                        const FastMarchingSource& source,
                                        const FastMarchingBehind& behind)
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
