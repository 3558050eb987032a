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
[[gnu::always_inline]] inline bool findSource(double u, double v, double base,
                                              FastMarchingSource& source)
{
  const double along = footOfSource(u, v, base);
  const double squared = (u - along) * (u + along);
  source = {along, std::sqrt(std::max(0.0, squared))};
  return squared >= -ON_BASE * base * base;
}

/// Do two labels add up to less than the base is long?
inline bool isSourceLine(double u, double v, double base)
{
  return u + v < base * (1.0 - ON_BASE);
}

/// Where two labels add up to less than the base is long, all from `first` to `last` along it may
/// be a source: no label is below its distance from there, and nothing nearer has both.
struct FastMarchingSourceLine
{
  double first, last;

  FastMarchingSourceLine(double u, double v, double base) : first(u), last(base - v) {}

  double nearestTo(double along) const { return std::min(std::max(along, first), last); }
};

/// The update of fast marching for the eikonal equation |grad T| F = 1 (J. A. Sethian, 1996) in a
/// triangle (R. Kimmel, J. A. Sethian: Computing Geodesic Paths on Manifolds, 1998), of a round
/// front: the distance of the corner from the source, which is u away from the origin. Infinite
/// where the way does not cross the base. Where the corner is nearer than the origin, `more` is
/// negative.
[[gnu::always_inline]] inline double sphericalUpdate(double u, const FastMarchingSource& source,
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

}  // namespace mesh_map
