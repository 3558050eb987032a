#ifndef MESH_MAP_SRC_CLOSEST_LEAF_H
#define MESH_MAP_SRC_CLOSEST_LEAF_H

#include <array>
#include <cmath>

#include "ray_simd.h"

namespace mesh_map {

/// A vector for each of four triangles.
using Vectors4 = std::array<Floats4, 3>;

inline Vectors4 minus(const Vectors4& a, const Vectors4& b)
{
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline Floats4 dot(const Vectors4& a, const Vectors4& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Vectors4 cross(const Vectors4& a, const Vectors4& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Floats4 root(Floats4 value)
{
#ifdef __SSE__
  return _mm_sqrt_ps(value);
#else
  return Floats4{std::sqrt(value[0]), std::sqrt(value[1]), std::sqrt(value[2]),
                 std::sqrt(value[3])};
#endif
}

inline Floats4 select(Ints4 mask, Floats4 yes, Floats4 no)
{
  return reinterpret_cast<Floats4>((mask & reinterpret_cast<Ints4>(yes)) |
                                   (~mask & reinterpret_cast<Ints4>(no)));
}

/// A point in floats: it is `head` + `tail`, up to 2^-47 of its largest coordinate.
struct SplitPoint
{
  Vectors4 head, tail;

  explicit SplitPoint(const double* point)
  {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto rounded = static_cast<float>(point[i]);
      head[i] = all4(rounded);
      tail[i] = all4(static_cast<float>(point[i] - rounded));
    }
  }

  /// From the point to others: wrong, per coordinate, by at most 2^-23 of itself and 2^-46 of the
  /// largest coordinate of the point (two subtractions, the first of which is exact or as large as
  /// the result, and what is missing of the point).
  Vectors4 to(const Vectors4& other) const { return minus(minus(other, head), tail); }
};

/// Four triangles that follow each other, seen from a point, in floats.
class LeafTriangles
{
 public:
  /// Reads 36 floats.
  LeafTriangles(const float* corners, const SplitPoint& point)
  {
    Vectors4 a, b, c;
    Floats4 b0, c1;
    a[0] = load4(corners), a[1] = load4(corners + 9), a[2] = load4(corners + 18);
    b0 = load4(corners + 27);
    transpose(a[0], a[1], a[2], b0);
    b[0] = b0;
    b[1] = load4(corners + 4), b[2] = load4(corners + 13), c[0] = load4(corners + 22);
    c1 = load4(corners + 31);
    transpose(b[1], b[2], c[0], c1);
    c[1] = c1;
    c[2] = Floats4{corners[8], corners[17], corners[26], corners[35]};
    a_ = point.to(a);
    b_ = point.to(b);
    c_ = point.to(c);
    for (std::size_t i = 0; i < 3; ++i) {
      lower_[i] = minimum(minimum(a_[i], b_[i]), c_[i]);
      upper_[i] = maximum(maximum(a_[i], b_[i]), c_[i]);
    }
  }

  /// Squares of the distances to their boxes.
  Floats4 squaredBoxDistances() const
  {
    Vectors4 gap;
    for (std::size_t i = 0; i < 3; ++i) {
      gap[i] = maximum(maximum(lower_[i], -upper_[i]), Floats4{});
    }
    return dot(gap, gap);
  }

  /// Lower bounds of the distances, close ones mostly.
  ///
  /// Whatever direction one looks in, a triangle is no nearer than its nearest corner along that
  /// direction. Along the normal, that is the distance of the plane; towards the nearest point of
  /// the nearest edge it is that of this point, where the nearest point of all is on an edge. So
  /// rounding makes directions worse, but no bound wrong: but for the rounding of the last steps,
  /// which is at most (5 * 2^-24) times the distance of the farthest corner (three products, two
  /// sums, and the errors of SplitPoint::to()), and is taken off, rounded up.
  Floats4 bounds() const
  {
    const Vectors4 u = minus(b_, a_), v = minus(c_, a_), side = minus(c_, b_);
    Vectors4 nearest = onEdge(a_, u);
    Floats4 squared = dot(nearest, nearest);
    nearer(onEdge(a_, v), nearest, squared);
    nearer(onEdge(b_, side), nearest, squared);
    const Floats4 largest = root(dot(farCorner(), farCorner()));
    return maximum(along(nearest), along(cross(u, v))) * 0x1.ffffep-1f - largest * 0x1p-21f;
  }

 private:
  static Vectors4 onEdge(const Vectors4& start, const Vectors4& side)
  {
    Floats4 t = -dot(start, side) / dot(side, side);
    t = maximum(minimum(t, all4(1.0f)), Floats4{});
    return {start[0] + t * side[0], start[1] + t * side[1], start[2] + t * side[2]};
  }

  static void nearer(const Vectors4& other, Vectors4& nearest, Floats4& squared)
  {
    const Floats4 other_squared = dot(other, other);
    const Ints4 take = other_squared < squared;
    for (std::size_t i = 0; i < 3; ++i) {
      nearest[i] = select(take, other[i], nearest[i]);
    }
    squared = minimum(other_squared, squared);
  }

  /// How far the triangles are at least along a direction or its opposite. A direction so small
  /// that its square loses digits says nothing.
  Floats4 along(const Vectors4& direction) const
  {
    const Floats4 a = dot(direction, a_), b = dot(direction, b_), c = dot(direction, c_);
    const Floats4 least = maximum(minimum(minimum(a, b), c), -maximum(maximum(a, b), c));
    const Floats4 squared = dot(direction, direction);
    return select(squared >= all4(1e-25f), least / root(squared), Floats4{});
  }

  Vectors4 farCorner() const
  {
    return {maximum(upper_[0], -lower_[0]), maximum(upper_[1], -lower_[1]),
            maximum(upper_[2], -lower_[2])};
  }

  Vectors4 a_, b_, c_, lower_, upper_;
};

}  // namespace mesh_map

#endif  // MESH_MAP_SRC_CLOSEST_LEAF_H
