#include <mesh_map/field_trace.h>
#include <mesh_map/parallel.h>

#include <cmath>
#include <cstddef>
#include <limits>

#include "field_surface.h"

namespace mesh_map {
namespace {

/// Thinner faces (sine of the angle between two sides, squared) have no
/// direction.
constexpr double NO_AREA = 1e-20;

/// A label is explained when what explains it says the same up to this part of
/// it.
constexpr double EXPLAINED = 1e-5;

/// Weights of two sides.
struct SideWeights
{
  double p, q;
};

/// From the common corner of the sides p and q of a triangle to where a front
/// came from that went straight: the point of its plane (as weights of p and q,
/// times some factor > 0) for which the differences of the squared distances
/// are those of the labels. Given are the squares of labels at the other ends
/// minus that at the corner, in lengths.
SideWeights towardsSource(double pp, double pq, double qq, double rise_p, double rise_q)
{
  const double a = pp - rise_p, b = qq - rise_q;
  return {qq * a - pq * b, pp * b - pq * a};
}

Vector3 combine(const SideWeights& weights, const Vector3& p, const Vector3& q)
{
  return {weights.p * p[0] + weights.q * q[0], weights.p * p[1] + weights.q * q[1],
          weights.p * p[2] + weights.q * q[2]};
}

/// The unit vector as floats; zeros where there is none.
void storeUnit(const Vector3& vector, double least, float* out)
{
  const double length = std::sqrt(dot(vector, vector));
  const double factor = length > least && std::isfinite(length) ? 1.0 / length : 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = static_cast<float>(factor * vector[i]);
  }
}

/// Which way down from one vertex explains its label best.
class VertexDirection
{
 public:
  VertexDirection(const FieldSurface& surface, std::uint32_t v)
      : surface_(&surface), v_(v), label_(surface.label(v)), at_(surface.position(v))
  {
  }

  /// Through the faces around, straight to the goal where it may be in one of
  /// them, or along edges.
  Vector3 find(ArrayView<std::uint32_t> faces, bool near_goal)
  {
    for (const std::uint32_t face : faces) {
      lookThrough(face);
    }
    for (std::size_t i = 0; near_goal && i < faces.size(); ++i) {
      if (surface_->isGoalIn(faces[i])) {
        lookToGoal(faces[i]);
      }
    }
    if (!(error_ <= EXPLAINED * label_)) {
      for (const std::uint32_t face : faces) {
        lookAlong(face);
      }
    }
    return direction_;
  }

 private:
  void offer(double error, const Vector3& direction)
  {
    if (error < error_) {
      error_ = error;
      direction_ = direction;
    }
  }

  void lookThrough(std::uint32_t face)
  {
    const std::uint32_t first = surface_->corner(face, 0), second = surface_->corner(face, 1),
                        third = surface_->corner(face, 2);
    const std::uint32_t a = first == v_ ? second : first, b = third == v_ ? second : third;
    const double u_a = surface_->label(a), u_b = surface_->label(b);
    if (!surface_->isReached(a) || !surface_->isReached(b) || a == b) {
      return;
    }
    const double scale = surface_->meanSlowness(face), per_square = 1.0 / (scale * scale);
    const Vector3 p = surface_->position(a) - at_, q = surface_->position(b) - at_;
    const double pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), area = pp * qq - pq * pq;
    if (!(area > NO_AREA * pp * qq) || !(scale > 0.0)) {
      return;
    }
    const SideWeights weights =
        towardsSource(pp, pq, qq, (u_a - label_) * (u_a + label_) * per_square,
                      (u_b - label_) * (u_b + label_) * per_square);
    if ((weights.p >= 0.0) & (weights.q >= 0.0)) {
      const Vector3 direction = combine(weights, p, q);
      const double length = scale * std::sqrt(dot(direction, direction)) / (2.0 * area);
      offer(std::abs(length - label_), direction);
    }
  }

  void lookToGoal(std::uint32_t face)
  {
    const Vector3 way = surface_->goal().position - at_;
    const double slowness = 0.5 * (surface_->slowness(v_) + surface_->goalSlowness(face));
    offer(std::abs(label_ - slowness * std::sqrt(dot(way, way))), way);
  }

  void lookAlong(std::uint32_t face)
  {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t w = surface_->corner(face, k);
      if (w != v_ && surface_->isReached(w) && surface_->label(w) < label_) {
        const Vector3 side = surface_->position(w) - at_;
        const double there =
            0.5 * (surface_->slowness(v_) + surface_->slowness(w)) * std::sqrt(dot(side, side));
        offer(std::abs(surface_->label(w) + there - label_), side);
      }
    }
  }

  const FieldSurface* surface_;
  std::uint32_t v_;
  double label_;
  Vector3 at_;
  double error_ = std::numeric_limits<double>::infinity();
  Vector3 direction_{};
};

}  // namespace

std::vector<float> vertexDirections(const TraceMesh& mesh, const SurfaceField& field,
                                    ArrayView<float> normals, unsigned threads)
{
  std::vector<float> directions(mesh.mesh.positions.size());
  const auto find = [&](const FieldSurface& surface, std::uint32_t v, bool near_goal) {
    if (!surface.isReached(v) || surface.label(v) > field.limit) {
      return;
    }
    const std::uint32_t first = mesh.vertex_faces.offsets[v];
    const Vector3 way = VertexDirection(surface, v)
                            .find({mesh.vertex_faces.values.data() + first,
                                   mesh.vertex_faces.offsets[v + 1] - first},
                                  near_goal);
    const float* const n = normals.data() + 3 * std::size_t{v};
    const double across = way[0] * n[0] + way[1] * n[1] + way[2] * n[2];
    storeUnit({way[0] - across * n[0], way[1] - across * n[1], way[2] - across * n[2]},
              1e-6 * std::sqrt(dot(way, way)), directions.data() + 3 * std::size_t{v});
  };
  parallelFor(mesh.mesh.vertexCount(), 4096, threads, [&]() -> RangeBody {
    return [&, surface = FieldSurface(mesh, field)](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        find(surface, static_cast<std::uint32_t>(v), false);
      }
    };
  });
  const FieldSurface surface(mesh, field);
  for (std::size_t k = 0; surface.hasGoal() && k < 3; ++k) {
    FieldPlace corner;
    corner.kind = FieldPlace::VERTEX;
    corner.a = surface.corner(field.goal_face, k);
    surface.forFacesAt(corner, [&](std::uint32_t face) {
      for (std::size_t i = 0; i < 3 && surface.isGoalIn(face); ++i) {
        find(surface, surface.corner(face, i), true);
      }
    });
  }
  return directions;
}

std::vector<float> faceDirections(const TraceMesh& mesh, const SurfaceField& field,
                                  unsigned threads)
{
  std::vector<float> directions(mesh.mesh.faces.size());
  parallelFor(mesh.mesh.faceCount(), 4096, threads, [&]() -> RangeBody {
    return [&, surface = FieldSurface(mesh, field)](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto face = static_cast<std::uint32_t>(i);
        double u[3];
        bool is_reached = true;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::uint32_t v = surface.corner(face, k);
          u[k] = surface.label(v);
          is_reached = is_reached && surface.isReached(v) && u[k] <= field.limit;
        }
        if (!is_reached) {
          continue;
        }
        const Vector3 at = surface.position(surface.corner(face, 0));
        const Vector3 p = surface.position(surface.corner(face, 1)) - at;
        const Vector3 q = surface.position(surface.corner(face, 2)) - at;
        const double pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), area = pp * qq - pq * pq;
        const double scale = surface.meanSlowness(face), per_square = 1.0 / (scale * scale);
        if (!(area > NO_AREA * pp * qq) || !(scale > 0.0)) {
          continue;
        }
        // the source as seen from corner 0, and from there to the middle
        SideWeights weights = towardsSource(pp, pq, qq, (u[1] - u[0]) * (u[1] + u[0]) * per_square,
                                            (u[2] - u[0]) * (u[2] + u[0]) * per_square);
        weights.p -= 2.0 * area / 3.0;
        weights.q -= 2.0 * area / 3.0;
        storeUnit(combine(weights, p, q), 0.0, directions.data() + 3 * i);
      }
    };
  });
  return directions;
}

}  // namespace mesh_map
