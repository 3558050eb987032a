#include <mesh_map/base/parallel.h>
#include <mesh_map/paths/field_trace.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "base/require.h"
#include "base/vector3.h"
#include "mesh/packed_position.h"
#include "paths/field_surface.h"

namespace mesh_map {

namespace {

/// Thinner faces (sine of the angle between two sides, squared) have no direction.
constexpr double NO_AREA = 1e-20;

/// Labels and slowness; without costs the latter is 1 everywhere.
template <bool HAS_COSTS>
class FieldValues
{
 public:
  explicit FieldValues(const SurfaceField& field)
      : labels_(field.labels.data()),
        slowness_(field.slowness.data()),
        limit_(std::min(field.limit, std::numeric_limits<double>::max()))
  {
  }

  double label(std::uint32_t v) const { return labels_[v]; }
  double slowness(std::uint32_t v) const { return HAS_COSTS ? double{slowness_[v]} : 1.0; }

  /// Open, and the front came there.
  bool isReached(std::uint32_t v) const { return isUpTo(v, std::numeric_limits<double>::max()); }
  bool isFinal(std::uint32_t v) const { return isUpTo(v, limit_); }

  double meanSlowness(std::uint32_t a, std::uint32_t b, std::uint32_t c) const
  {
    return HAS_COSTS ? (slowness(a) + slowness(b) + slowness(c)) * (1.0 / 3.0) : 1.0;
  }

 private:
  bool isUpTo(std::uint32_t v, double most) const
  {
    return labels_[v] >= 0.0 && labels_[v] <= most && (!HAS_COSTS || std::isfinite(slowness_[v]));
  }

  const double* labels_;
  const float* slowness_;
  double limit_;
};

/// The unit vector as floats; zeros where it is not longer than `least`, squared.
inline void storeUnit(const Vector3& vector, double least, float* out)
{
  const double squared = dot(vector, vector);
  const double factor = squared > least && std::isfinite(squared) ? 1.0 / std::sqrt(squared) : 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = static_cast<float>(factor * vector[i]);
  }
}

/// Calls body(values) with what the field holds.
template <class Body>
void withValues(const SurfaceField& field, const Body& body)
{
  if (field.slowness.data() != nullptr) {
    body(FieldValues<true>(field));
  } else {
    body(FieldValues<false>(field));
  }
}

constexpr double FAR = std::numeric_limits<double>::infinity();

/// Vertices or faces that a thread takes at once.
constexpr std::size_t CHUNK = 8192;

/// What is shorter by this part after its projection into a plane was across it.
constexpr double ACROSS = 1e-6;

/// Of the ways down from one vertex, that whose potential is nearest to its label: where the front
/// went straight through all faces, the lowest.
template <bool HAS_COSTS>
class VertexDirection
{
 public:
  VertexDirection(const FieldValues<HAS_COSTS>& values, const FastMarchingMesh& mesh,
                  std::uint32_t v)
      : values_(values), mesh_(mesh), v_(v), label_(values.label(v)), squared_(label_ * label_)
  {
  }

  /// Through the faces around, straight to where the source lies beyond them, or along edges.
  void lookAround()
  {
    Neighbor a, b;
    for (const FastMarchingCorner& corner : mesh_.corners(v_)) {
      if (corner.a == v_) {
        continue;
      }
      if (corner.a == b.vertex) {  // as in a fan
        a = b;
      } else {
        a = neighbor(corner.a);
      }
      b = neighbor(corner.b);
      if (a.isReached() && b.isReached() && std::min(a.label, b.label) < label_) {
        lookThrough(a, b);
      }
    }
  }

  /// Straight to a point, which takes `time`.
  void lookTo(const Vector3& side, double time) { offer(time * time, side); }

  const Vector3& direction() const { return direction_; }

 private:
  struct Neighbor
  {
    std::uint32_t vertex = NO_INDEX;
    double label = FAR;
    Vector3 side{};

    bool isReached() const { return label < FAR; }
  };

  Neighbor neighbor(std::uint32_t vertex)
  {
    Neighbor result;
    result.vertex = vertex;
    if (!values_.isReached(vertex)) {
      return result;
    }
    result.label = values_.label(vertex);
    result.side = between(mesh_.position(v_), mesh_.position(vertex));
    if (result.label < label_) {
      const double slow = 0.5 * (values_.slowness(v_) + values_.slowness(vertex));
      const double total = result.label + slow * norm(result.side);
      offer(total * total, result.side);
    }
    return result;
  }

  /// From the labels of the two others follows where the source lies in the plane of the face, and
  /// where the way there crosses the side between them.
  void lookThrough(const Neighbor& a, const Neighbor& b)
  {
    const double scale = values_.meanSlowness(v_, a.vertex, b.vertex);
    const double per_square = 1.0 / (scale * scale);
    const Vector3 base = b.side - a.side, area = cross(a.side, b.side);
    const double u_squared = a.label * a.label * per_square;
    const double length_squared = dot(base, base), area_squared = dot(area, area);
    // All of these times the length of the base.
    const double along =
        0.5 * (length_squared + (a.label - b.label) * (a.label + b.label) * per_square);
    const double beyond_squared = u_squared * length_squared - along * along;
    if (!(beyond_squared >= 0.0 &&
          area_squared > NO_AREA * dot(a.side, a.side) * dot(b.side, b.side))) {
      return;
    }
    const double here = -dot(a.side, base), beyond = std::sqrt(beyond_squared);
    const double height = std::sqrt(area_squared), depth = beyond + height;
    const double crossing = here * beyond + along * height, most = length_squared * depth;
    if (!(crossing >= 0.0 && crossing <= most)) {
      return;
    }
    const double gap = here - along;
    const double total = scale * scale * (gap * gap + depth * depth) / length_squared;
    if (isBetter(total)) {
      const double share = crossing / most;
      offer(total, a.side + share * base);
    }
  }

  bool isBetter(double total) const { return std::abs(total - squared_) < error_; }

  /// `total`: what the vertex would have by this way, squared.
  void offer(double total, const Vector3& direction)
  {
    if (isBetter(total)) {
      error_ = std::abs(total - squared_);
      direction_ = direction;
    }
  }

  const FieldValues<HAS_COSTS>& values_;
  const FastMarchingMesh& mesh_;
  std::uint32_t v_;
  double label_, squared_;
  double error_ = FAR;
  Vector3 direction_{};
};

/// Into the plane across the normal.
void storeAcross(const Vector3& way, const float* normal, float* out)
{
  const Vector3 up = pointOf(normal);
  storeUnit(way - dot(way, up) * up, ACROSS * ACROSS * dot(way, way), out);
}

/// Where the goal is within a face, straight to it.
template <bool HAS_COSTS>
void storeAtGoal(const FieldSurface& surface, const FastMarchingMesh& front,
                 const FieldValues<HAS_COSTS>& values, std::uint32_t goal_face,
                 ArrayView<float> normals, LargeArray<float>& directions)
{
  const auto store = [&](std::uint32_t face, std::uint32_t v) {
    const Vector3 way = surface.goal().position - surface.position(v);
    VertexDirection<HAS_COSTS> found(values, front, v);
    found.lookAround();
    found.lookTo(way, 0.5 * (values.slowness(v) + surface.goalSlowness(face)) * norm(way));
    storeAcross(found.direction(), normals.data() + 3 * std::size_t{v},
                directions.data() + 3 * std::size_t{v});
  };
  for (std::size_t k = 0; k < 3; ++k) {
    FieldPlace corner;
    corner.kind = FieldPlace::VERTEX;
    corner.a = surface.corner(goal_face, k);
    surface.forFacesAt(corner, [&](std::uint32_t face) {
      for (std::size_t i = 0; i < 3 && surface.isGoalIn(face); ++i) {
        if (values.isFinal(surface.corner(face, i))) {
          store(face, surface.corner(face, i));
        }
      }
    });
  }
}

}  // namespace

LargeArray<float> vertexDirections(const TraceMesh& mesh, const FastMarchingMesh& front,
                                   const SurfaceField& field, ArrayView<float> normals,
                                   unsigned threads)
{
  require(front.vertexCount() == mesh.mesh.vertexCount() &&
              normals.size() == mesh.mesh.positions.size(),
          "the corners or normals are of another mesh");
  LargeArray<float> directions(mesh.mesh.positions.size());
  withValues(field, [&](auto values) {
    const auto one = [&, values](std::size_t i) {
      const auto v = static_cast<std::uint32_t>(i);
      VertexDirection found(values, front, v);
      if (values.isFinal(v)) {
        found.lookAround();
      }
      storeAcross(found.direction(), normals.data() + 3 * i, directions.data() + 3 * i);
    };
    parallelEach(front.vertexCount(), CHUNK, threads, one);
    const FieldSurface surface(mesh, field);
    if (surface.hasGoal()) {
      storeAtGoal(surface, front, values, field.goal_face, normals, directions);
    }
  });
  return directions;
}

namespace {

/// Against the gradient, from where the labels of all three corners say that the source lies: the
/// point of the plane (by trilateration) for
/// which the differences of the squared distances are those of the labels.
template <bool HAS_COSTS>
void storeAtFace(const FieldValues<HAS_COSTS>& values, const MeshView& mesh, std::size_t face,
                 float* out)
{
  const std::uint32_t* const v = mesh.faces.data() + 3 * face;
  out[0] = out[1] = out[2] = 0.0f;
  const double scale = values.meanSlowness(v[0], v[1], v[2]);
  if (!(values.isFinal(v[0]) && values.isFinal(v[1]) && values.isFinal(v[2]) && scale > 0.0)) {
    return;
  }
  const Vector3 p = difference(mesh.vertex(v[1]), mesh.vertex(v[0]));
  const Vector3 q = difference(mesh.vertex(v[2]), mesh.vertex(v[0]));
  const double pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), area = pp * qq - pq * pq;
  if (!(area > NO_AREA * pp * qq)) {
    return;
  }
  const double per_square = 1.0 / (scale * scale);
  const double u[3] = {values.label(v[0]), values.label(v[1]), values.label(v[2])};
  const double along_p = pp - (u[1] - u[0]) * (u[1] + u[0]) * per_square;
  const double along_q = qq - (u[2] - u[0]) * (u[2] + u[0]) * per_square;
  // As weights of p and q, times twice the squared area; less what leads to the middle.
  const double middle = area * (2.0 / 3.0);
  const double to_p = qq * along_p - pq * along_q - middle;
  const double to_q = pp * along_q - pq * along_p - middle;
  storeUnit(to_p * p + to_q * q, 0.0, out);
}

}  // namespace

LargeArray<float> faceDirections(const TraceMesh& mesh, const SurfaceField& field, unsigned threads)
{
  LargeArray<float> directions(mesh.mesh.faces.size());
  withValues(field, [&](auto values) {
    const auto one = [&, values](std::size_t face) {
      storeAtFace(values, mesh.mesh, face, directions.data() + 3 * face);
    };
    parallelEach(mesh.mesh.faceCount(), CHUNK, threads, one);
  });
  return directions;
}

}  // namespace mesh_map
