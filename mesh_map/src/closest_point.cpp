#include <mesh_map/closest_point.h>
#include <mesh_map/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

namespace mesh_map {
namespace {

using Vector = std::array<double, 3>;

Vector difference(const float* a, const float* b)
{
  return {double{a[0]} - b[0], double{a[1]} - b[1], double{a[2]} - b[2]};
}

double dot(const Vector& a, const Vector& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector cross(const Vector& a, const Vector& b)
{
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Candidates are points of the triangle itself, given by their weights, so none can seem nearer
/// than the triangle is.
class Candidates
{
 public:
  Candidates(const float* a, const float* b, const float* c, const double* point)
      : u_(difference(b, a)),
        v_(difference(c, a)),
        w_{point[0] - a[0], point[1] - a[1], point[2] - a[2]}
  {
  }

  void add(double beta, double gamma)
  {
    const Vector gap = {w_[0] - beta * u_[0] - gamma * v_[0], w_[1] - beta * u_[1] - gamma * v_[1],
                        w_[2] - beta * u_[2] - gamma * v_[2]};
    const double squared = dot(gap, gap);
    if (squared < squared_) {
      squared_ = squared;
      beta_ = beta;
      gamma_ = gamma;
    }
  }

  /// The foot of the point on the plane, where it lies inside (equations 1 and 2 of the paper).
  void addFoot()
  {
    const Vector n = cross(u_, v_);
    const double nn = dot(n, n);
    if (!(nn > 0.0)) {
      return;
    }
    const double gamma = dot(cross(u_, w_), n) / nn;
    const double beta = dot(cross(w_, v_), n) / nn;
    if (beta >= 0.0 && gamma >= 0.0 && beta + gamma <= 1.0) {
      add(beta, gamma);
    }
  }

  void addEdges()
  {
    const Vector side = {v_[0] - u_[0], v_[1] - u_[1], v_[2] - u_[2]};
    const Vector from_b = {w_[0] - u_[0], w_[1] - u_[1], w_[2] - u_[2]};
    add(along(w_, u_), 0.0);
    add(0.0, along(w_, v_));
    const double t = along(from_b, side);
    add(1.0 - t, t);
  }

  double squared() const { return squared_; }
  double beta() const { return beta_; }
  double gamma() const { return gamma_; }

 private:
  /// Where on the segment from 0 to `side` is nearest to `to`, from 0 to 1.
  static double along(const Vector& to, const Vector& side)
  {
    const double length = dot(side, side);
    return length > 0.0 ? std::min(1.0, std::max(0.0, dot(to, side) / length)) : 0.0;
  }

  Vector u_, v_, w_;
  double squared_ = std::numeric_limits<double>::infinity();
  double beta_ = 0.0, gamma_ = 0.0;
};

/// A lower bound of the squared distance: that to the box around the triangle.
double squaredBoxDistance(const float* a, const float* b, const float* c, const double* point)
{
  double squared = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double low = std::min({a[i], b[i], c[i]}), high = std::max({a[i], b[i], c[i]});
    const double gap = std::max({low - point[i], point[i] - high, 0.0});
    squared += gap * gap;
  }
  return squared;
}

struct Best
{
  double squared = std::numeric_limits<double>::infinity();
  std::uint32_t face = NO_INDEX;

  void offer(double other_squared, std::uint32_t other_face)
  {
    if (other_squared < squared || (other_squared == squared && other_face < face)) {
      squared = other_squared;
      face = other_face;
    }
  }
};

const float* corner(const MeshView& mesh, std::size_t face, std::size_t which)
{
  return mesh.positions.data() + 3 * std::size_t{mesh.faces[3 * face + which]};
}

/// Of the faces [begin, end), the one nearest to the point; `best` is what has been found before.
Best nearestFace(const MeshView& mesh, const double* point, std::size_t begin, std::size_t end,
                 Best best)
{
  constexpr double rounding = 1.0 - 1e-12;
  for (std::size_t f = begin; f < end; ++f) {
    const float* const a = corner(mesh, f, 0);
    const float* const b = corner(mesh, f, 1);
    const float* const c = corner(mesh, f, 2);
    if (squaredBoxDistance(a, b, c, point) * rounding > best.squared) {
      continue;
    }
    Candidates candidates(a, b, c, point);
    candidates.addFoot();
    candidates.addEdges();
    best.offer(candidates.squared(), static_cast<std::uint32_t>(f));
  }
  return best;
}

bool isFinite(const double* point)
{
  return std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
}

SurfaceHit hitOf(const MeshView& mesh, const Best& best, const double* point, double max_distance)
{
  if (best.face == NO_INDEX || !(std::sqrt(best.squared) <= max_distance)) {
    return {};
  }
  SurfaceHit hit = closestPointOnTriangle(corner(mesh, best.face, 0), corner(mesh, best.face, 1),
                                          corner(mesh, best.face, 2), point);
  hit.face = best.face;
  return hit;
}

}  // namespace

SurfaceHit closestPointOnTriangle(const float* a, const float* b, const float* c,
                                  const double* point)
{
  Candidates candidates(a, b, c, point);
  candidates.addFoot();
  candidates.addEdges();
  SurfaceHit hit;
  const double beta = candidates.beta(), gamma = candidates.gamma();
  hit.barycentric = {1.0 - beta - gamma, beta, gamma};
  for (std::size_t i = 0; i < 3; ++i) {
    hit.position[i] = a[i] + beta * (double{b[i]} - a[i]) + gamma * (double{c[i]} - a[i]);
  }
  hit.distance = std::sqrt(candidates.squared());
  return hit;
}

std::vector<SurfaceHit> closestPoints(const MeshView& mesh, ArrayView<double> points,
                                      double max_distance, unsigned threads)
{
  const std::size_t point_count = points.size() / 3;
  std::vector<SurfaceHit> hits(point_count);
  if (point_count == 1) {
    // One point: the threads share the faces.
    std::mutex mutex;
    Best best;
    const double* const point = points.data();
    if (isFinite(point)) {
      constexpr std::size_t faces_per_chunk = 65536;
      parallelFor(mesh.faceCount(), faces_per_chunk, threads, [&]() -> RangeBody {
        return [&, own = Best()](std::size_t begin, std::size_t end) mutable {
          own = nearestFace(mesh, point, begin, end, own);
          const std::lock_guard<std::mutex> lock(mutex);
          best.offer(own.squared, own.face);
        };
      });
    }
    hits[0] = hitOf(mesh, best, point, max_distance);
    return hits;
  }
  parallelFor(point_count, 16, threads, [&]() -> RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const double* const point = points.data() + 3 * i;
        if (isFinite(point)) {
          hits[i] = hitOf(mesh, nearestFace(mesh, point, 0, mesh.faceCount(), Best()), point,
                          max_distance);
        }
      }
    };
  });
  return hits;
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

}  // namespace mesh_map
