#include <mesh_map/bvh/closest/bvh_closest.h>

#include <mesh_map/bvh/tree/back_end.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/require.h"
#include "base/run.h"
#include "base/simd.h"
#include "bvh/closest/normal_filter.h"
#include "bvh/closest/triangle_point.h"

namespace mesh_map {

namespace {

/// Radians by which an angle may seem larger than it is.
constexpr double ROUNDING = 1e-12;

/// A vector of length 1, whatever its length is (not 0).
Vector3 unit(const double* vector)
{
  const double largest = std::max({std::abs(vector[0]), std::abs(vector[1]), std::abs(vector[2])});
  const Vector3 scaled = {vector[0] / largest, vector[1] / largest, vector[2] / largest};
  return scaled / norm(scaled);
}

}  // namespace

NormalFilter::NormalFilter(const double* direction, double max_angle)
    : all_(max_angle >= PI),
      direction_(unit(direction)),  // NaN for a direction of 0 or that is not finite
      max_angle_(max_angle),
      cosine_(all_ ? -1.0 : std::cos(max_angle))
{
  valid_ = isFinite(direction_) && max_angle >= 0.0;
}

bool NormalFilter::within(const float* corners) const
{
  const Vector3 n = triangleNormal(corners, corners + 3, corners + 6);
  const double length = norm(n), along = dot(n, direction_);
  if (!valid_ || !(length > 0.0)) {
    return false;
  }
  // A cosine is quick, but cannot tell small angles apart. Its error, as computed here, is far
  // below the margin, which in turn stands for more than ROUNDING radians.
  constexpr double MARGIN = 1e-9;
  const double above = along - cosine_ * length;
  if (std::abs(above) > MARGIN * length) {
    return above > 0.0;
  }
  return angleBetween(n, direction_) <= max_angle_ + ROUNDING;
}

namespace {

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

/// A subtree to be searched.
struct NearTask
{
  std::uint32_t child, count;
  float squared;  // at most the square of the distance to its box
};

/// The query in floats, which only say what cannot be the nearest.
struct NearQuery
{
  SplitPoint split;     // in the coordinates of the mesh
  Vectors4 low, high;   // in those of the boxes, rounded down and up
  float rounding;       // of a distance, absolutely
  float reach;          // what is farther than this does not matter
  float squared_reach;  // the same for squares

  NearQuery(const Bvh& bvh, const double* point, double distance) : split(point)
  {
    double largest = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto local = static_cast<float>(point[i] - bvh.center()[i]);
      const float step = std::abs(local) * 0x1p-23f + 1e-30f;  // at least the next float
      low[i] = all4(local - step);
      high[i] = all4(local + step);
      largest = std::max(largest, std::abs(point[i]));
    }
    // SplitPoint::to() in each of three coordinates; and what underflows
    rounding = static_cast<float>(largest * 0x1p-45) + 1e-20f;
    limit(distance);
  }

  /// Distances and their squares come out of floats wrong by less than 2^-21 and 2^-20 of
  /// themselves, by 8 roundings of 2^-24; those of TrianglePoint by far less.
  void limit(double distance)
  {
    reach = std::numeric_limits<float>::max();
    squared_reach = reach;
    if (distance < 1e18) {
      reach = static_cast<float>(distance) * (1.0f + 0x1p-20f) + rounding;
      squared_reach = reach * reach * (1.0f + 0x1p-19f) + 1e-37f;
    }
  }

  /// Squares of the distances to the boxes of a node (C. Ericson: Real-Time Collision Detection,
  /// 2004, 5.1.3): at most the true ones, but for rounding.
  Floats4 squaredDistances(const BvhNode& node) const
  {
    Vectors4 gap;
    for (std::size_t i = 0; i < 3; ++i) {
      gap[i] = maximum(maximum(load4(node.lower[i]) - high[i], low[i] - load4(node.upper[i])),
                       Floats4{});
    }
    return dot(gap, gap);
  }
};

constexpr double INF = std::numeric_limits<double>::infinity();

/// A subtree, and what is known of the distance to anything in it.
struct FarTask
{
  std::uint32_t child = 0;
  std::size_t first = 0, count = 0;
  double nearest = 0.0, farthest = 0.0;

  FarTask() = default;

  /// Of a box in local coordinates. Distances are computed by the same steps as those to triangles,
  /// and these never fall where a gap grows: no triangle seems nearer or farther than its box.
  FarTask(const Bvh& bvh, const double* point, const std::array<float, 3>& lower,
          const std::array<float, 3>& upper)
  {
    Vector3 near_gap{}, far_gap{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double center = bvh.center()[i];
      const double above = std::nextafter(center + lower[i], -INF) - point[i];
      const double below = point[i] - std::nextafter(center + upper[i], INF);
      near_gap[i] = std::max({above, below, 0.0});
      far_gap[i] = std::max(-above, -below);
    }
    nearest = lengthOf(near_gap);
    farthest = lengthOf(far_gap);
  }
};

/// Looks for the closest point of one query after another. What it found for the last one is where
/// it starts with the next, which changes the time it takes but not the answer.
class ClosestSearch
{
 public:
  ClosestSearch(const Bvh& bvh, const ClosestOptions& options) : bvh_(bvh), options_(options) {}

  /// `normal` has 3 numbers or is null.
  SurfaceHit operator()(const double* point, const double* normal)
  {
    point_ = point;
    normals_ = normal == nullptr ? NormalFilter() : NormalFilter(normal, options_.max_angle);
    distance_ = options_.max_distance;
    face_ = NO_INDEX;
    if (!isFinite(Vector3{point[0], point[1], point[2]}) || !normals_.valid() ||
        !(distance_ >= 0.0)) {
      return {};
    }
    if (triangle_ != NO_TRIANGLE) {
      offer(triangle_);
    }
    if (isFar()) {
      searchFar();
    } else {
      searchNear();
    }
    if (face_ == NO_INDEX) {
      return {};
    }
    const float* const found = corners(triangle_);
    SurfaceHit hit = surfacePoint(found, found + 3, found + 6, beta_gamma_[0], beta_gamma_[1]);
    hit.face = face_;
    hit.distance = distance_;
    return hit;
  }

 private:
  /// Asks TrianglePoint for a triangle and, if it is better, the filters whether it counts.
  void offer(std::size_t triangle)
  {
    const float* const found = corners(triangle);
    const TrianglePoint nearest(found, found + 3, found + 6, point_);
    if (nearest.distance() > distance_) {
      return;
    }
    const std::uint32_t face = bvh_.faces()[triangle];
    if ((nearest.distance() < distance_ || face < face_) && counts(triangle)) {
      distance_ = nearest.distance();
      face_ = face;
      triangle_ = triangle;
      beta_gamma_ = {nearest.beta(), nearest.gamma()};
    }
  }

  bool counts(std::size_t triangle) const
  {
    return (options_.mask.empty() || options_.mask[bvh_.faces()[triangle]] != 0) &&
           normals_(corners(triangle));
  }

  /// Looks with floats: where the mesh is large, seen from the point.
  void searchNear()
  {
    NearQuery query(bvh_, point_, distance_);
    const BvhNode* const nodes = bvh_.nodes().data();
    NearTask stack[BVH_STACK];
    std::size_t size = 0;
    NearTask task = {0, 0, 0.0f};
    for (;;) {
      while (!isLeaf(task.child)) {
        const BvhNode& node = nodes[task.child];
        const Floats4 squared = query.squaredDistances(node);
        // slots without a child are at infinity, beyond any reach
        unsigned left = bits(squared <= all4(query.squared_reach));
        if (left == 0) {
          task.count = 0;
          break;
        }
        alignas(16) float distances[BVH_WIDTH];
        std::memcpy(distances, &squared, sizeof(distances));
        unsigned k = lowestBit(left);
        task = {node.child[k], node.count[k], distances[k]};
        const std::size_t bottom = size;
        for (left &= left - 1; left != 0; left &= left - 1) {
          k = lowestBit(left);
          NearTask other = {node.child[k], node.count[k], distances[k]};
          if (other.squared < task.squared) {
            std::swap(other, task);
          }
          std::size_t place = size++;
          for (; place > bottom && stack[place - 1].squared < other.squared; --place) {
            stack[place] = stack[place - 1];
          }
          stack[place] = other;
        }
      }
      if (task.count > 0) {
        searchLeaf(query, task.child & ~BVH_LEAF, task.count);
      }
      do {
        if (size == 0) {
          return;
        }
        task = stack[--size];
      } while (task.squared > query.squared_reach);
    }
  }

  void searchLeaf(NearQuery& query, std::size_t first, unsigned count)
  {
    const LeafTriangles triangles(corners(first), query.split);
    unsigned left =
        bits(triangles.squaredBoxDistances() <= all4(query.squared_reach)) & ((1u << count) - 1);
    if (left == 0) {
      return;
    }
    const Floats4 bounds = triangles.bounds();
    left &= ~bits(bounds > all4(query.reach));
    while (left != 0) {
      unsigned next = lowestBit(left);
      for (unsigned others = left & (left - 1); others != 0; others &= others - 1) {
        const unsigned other = lowestBit(others);
        next = bounds[other] < bounds[next] ? other : next;
      }
      offer(first + next);
      query.limit(distance_);
      left &= ~(1u << next) & ~bits(bounds > all4(query.reach));
    }
  }

  /// Looks with doubles: where the mesh is so far away that floats would hardly tell faces apart.
  void searchFar()
  {
    FarTask stack[BVH_STACK];
    std::size_t size = 0;
    FarTask root(bvh_, point_, bvh_.lower(), bvh_.upper());
    root.count = bvh_.faceCount();
    stack[size++] = root;
    while (size > 0) {
      const FarTask task = stack[--size];
      if (task.nearest > distance_ || allAsNear(task)) {
        continue;
      }
      if (isLeaf(task.child)) {
        for (std::size_t i = task.first; i < task.first + task.count; ++i) {
          offer(i);
        }
        continue;
      }
      const BvhNode& node = bvh_.nodes()[task.child];
      const std::size_t bottom = size;
      std::size_t first = task.first;
      for (std::size_t k = 0; k < BVH_WIDTH; ++k) {
        if (node.child[k] == BVH_NO_CHILD) {
          continue;
        }
        FarTask child(bvh_, point_, {node.lower[0][k], node.lower[1][k], node.lower[2][k]},
                      {node.upper[0][k], node.upper[1][k], node.upper[2][k]});
        child.child = node.child[k];
        child.first = first;
        child.count = node.count[k];
        first += child.count;
        std::size_t place = size++;
        for (; place > bottom && stack[place - 1].nearest < child.nearest; --place) {
          stack[place] = stack[place - 1];
        }
        stack[place] = child;
      }
    }
  }

  bool allAsNear(const FarTask& task)
  {
    if (task.nearest != task.farthest) {
      return false;
    }
    const std::size_t end = task.first + task.count;
    for (std::size_t i = task.first; i < end; ++i) {
      if (face_ == 0 && distance_ == task.nearest) {
        break;  // none is better
      }
      if (task.nearest < distance_ || bvh_.faces()[i] < face_) {
        offer(i);
      }
    }
    return true;
  }

  bool isFar() const
  {
    double away = 0.0, size = 0.0, numbers = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double center = bvh_.center()[i];
      away = std::max(away, std::abs(point_[i] - center));
      numbers = std::max({numbers, std::abs(point_[i]), std::abs(center)});
      size = std::max({size, std::abs(double{bvh_.lower()[i]}), std::abs(double{bvh_.upper()[i]})});
    }
    // Seen from 16 times its size, floats of 24 bits still tell a millionth of the mesh apart.
    // Beyond the other limits their squares would overflow or underflow.
    constexpr double MANY_SIZES = 16.0, LARGE = 1e17, SMALL = 1e-12;
    return !(away <= MANY_SIZES * size && numbers < LARGE && size < LARGE && size > SMALL);
  }

  const float* corners(std::size_t triangle) const { return bvh_.corners().data() + 9 * triangle; }

  const Bvh& bvh_;
  const ClosestOptions& options_;
  const double* point_ = nullptr;
  NormalFilter normals_;
  double distance_ = 0.0;                         // of the best, or the maximum
  std::uint32_t face_ = NO_INDEX;                 // the best
  std::size_t triangle_ = NO_TRIANGLE;            // the best, or that of the last query
  std::array<double, 2> beta_gamma_{{0.0, 0.0}};  // weights of its second and third corner

  static constexpr std::size_t NO_TRIANGLE = static_cast<std::size_t>(-1);
};

void check(const Bvh& bvh, std::size_t points, const ClosestOptions& options)
{
  const std::size_t normals = options.normals.size(), mask = options.mask.size();
  require(normals == 0 || normals == 3 || normals == 3 * points,
          "normals of " + std::to_string(normals) + " numbers: 3 for each of " +
              std::to_string(points) + " points, 3 for all, or none");
  require(mask == 0 || mask == bvh.faceCount(),
          "a mask of " + std::to_string(mask) + " numbers: one for each of " +
              std::to_string(bvh.faceCount()) + " faces, or none");
}

const double* normalOf(const ClosestOptions& options, std::size_t point)
{
  const std::size_t numbers = options.normals.size();
  return numbers == 0 ? nullptr : options.normals.data() + (numbers == 3 ? 0 : 3 * point);
}

}  // namespace

SurfaceHit closestPointOnTriangle(const float* a, const float* b, const float* c,
                                  const double* point)
{
  const TrianglePoint nearest(a, b, c, point);
  SurfaceHit hit = surfacePoint(a, b, c, nearest.beta(), nearest.gamma());
  hit.distance = nearest.distance();
  return hit;
}

VertexHit closestVertex(ArrayView<float> positions, ArrayView<std::uint8_t> eligible,
                        const double* point, double max_distance)
{
  double best = std::numeric_limits<double>::infinity();
  std::uint32_t best_vertex = NO_INDEX;
  if (isFinite(point)) {
    for (std::size_t v = 0; v < positions.size() / 3; ++v) {
      const double x = positions[3 * v] - point[0];
      const double y = positions[3 * v + 1] - point[1];
      const double z = positions[3 * v + 2] - point[2];
      const double squared = x * x + y * y + z * z;
      if (squared < best && (eligible.empty() || eligible[v])) {
        best = squared;
        best_vertex = static_cast<std::uint32_t>(v);
      }
    }
  }
  const double distance = std::sqrt(best);
  if (best_vertex == NO_INDEX || !(distance <= max_distance)) {
    return {};
  }
  return {best_vertex, distance};
}

SurfaceHits::SurfaceHits(std::size_t count)
    : faces(count), distances(count), positions(3 * count), barycentric(3 * count)
{
}

void SurfaceHits::set(std::size_t index, const SurfaceHit& hit)
{
  faces[index] = hit.face;
  distances[index] = hit.distance;
  std::copy(hit.position.begin(), hit.position.end(), positions.begin() + 3 * index);
  std::copy(hit.barycentric.begin(), hit.barycentric.end(), barycentric.begin() + 3 * index);
}

SurfaceHit closestPoint(const Bvh& bvh, const double* point, const ClosestOptions& options)
{
  check(bvh, 1, options);
  countQueries(BackEnd::NATIVE, Query::CLOSEST_POINT, 1);
  return ClosestSearch(bvh, options)(point, normalOf(options, 0));
}

SurfaceHits closestPoints(const Bvh& bvh, ArrayView<double> points, const ClosestOptions& options,
                          const BvhOptions& run_options)
{
  const std::size_t count = pointCount(points);
  check(bvh, count, options);
  SurfaceHits hits(count);
  Run run(run_options);
  constexpr std::size_t chunk = 256;
  run.each(count, chunk, 1.0, [&, search = ClosestSearch(bvh, options)](std::size_t i) mutable {
    run.check();  // one point can take long: far away, or among faces that do not count
    hits.set(i, search(points.data() + 3 * i, normalOf(options, i)));
  });
  run.finish();
  countQueries(BackEnd::NATIVE, Query::CLOSEST_POINT, count);
  return hits;
}

}  // namespace mesh_map
