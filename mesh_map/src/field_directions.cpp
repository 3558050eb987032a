#include <mesh_map/field_trace.h>
#include <mesh_map/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "field_surface.h"
#include "field_values.h"

namespace mesh_map {
namespace {

constexpr double FAR = std::numeric_limits<double>::infinity();

/// Vertices that a thread takes at once.
constexpr std::size_t CHUNK = 8192;

/// What is shorter by this part after its projection into a plane was across it.
constexpr double ACROSS = 1e-6;

/// Of the ways down from one vertex, that whose potential is nearest to its label: where the front
/// went straight through all faces, the lowest.
template <bool HAS_COSTS>
class VertexDirection
{
 public:
  VertexDirection(const FieldValues<HAS_COSTS>& values, const FrontMesh& mesh, std::uint32_t v)
      : values_(values), mesh_(mesh), v_(v), label_(values.label(v)), squared_(label_ * label_)
  {
  }

  /// Through the faces around, straight to where the source lies beyond them, or along edges.
  void lookAround()
  {
    const FrontCorner* const end = mesh_.cornersEnd(v_);
    Neighbor a, b;
    for (const FrontCorner* corner = mesh_.cornersBegin(v_); corner != end; ++corner) {
      if (corner->a == v_) {
        continue;
      }
      if (corner->a == b.vertex) {  // as in a fan
        a = b;
      } else {
        a = neighbor(corner->a);
      }
      b = neighbor(corner->b);
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
    const PackedPosition &from = mesh_.position(v_), &to = mesh_.position(vertex);
    result.label = values_.label(vertex);
    result.side = {double{to.x} - from.x, double{to.y} - from.y, double{to.z} - from.z};
    if (result.label < label_) {
      const double slow = 0.5 * (values_.slowness(v_) + values_.slowness(vertex));
      const double total = result.label + slow * std::sqrt(dot(result.side, result.side));
      offer(total * total, result.side);
    }
    return result;
  }

  /// From the labels of the two others follows where the source lies in the plane of the face, and
  /// where the way there crosses the side between them.
  void lookThrough(const Neighbor& a, const Neighbor& b)
  {
    const double scale = values_.meanSlowness(v_, a.vertex, b.vertex);
    const double per_square = HAS_COSTS ? 1.0 / (scale * scale) : 1.0;
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
      offer(total, {a.side[0] + share * base[0], a.side[1] + share * base[1],
                    a.side[2] + share * base[2]});
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
  const FrontMesh& mesh_;
  std::uint32_t v_;
  double label_, squared_;
  double error_ = FAR;
  Vector3 direction_{};
};

/// Into the plane across the normal.
void storeAcross(const Vector3& way, const float* normal, float* out)
{
  const double across = way[0] * normal[0] + way[1] * normal[1] + way[2] * normal[2];
  storeUnit({way[0] - across * normal[0], way[1] - across * normal[1], way[2] - across * normal[2]},
            ACROSS * ACROSS * dot(way, way), out);
}

/// Where the goal is within a face, straight to it.
template <bool HAS_COSTS>
void storeAtGoal(const FieldSurface& surface, const FrontMesh& front, const SurfaceField& field,
                 ArrayView<float> normals, LargeArray<float>& directions)
{
  const FieldValues<HAS_COSTS> values(field);
  const auto store = [&](std::uint32_t face, std::uint32_t v) {
    const Vector3 way = surface.goal().position - surface.position(v);
    VertexDirection<HAS_COSTS> found(values, front, v);
    found.lookAround();
    found.lookTo(
        way, 0.5 * (values.slowness(v) + surface.goalSlowness(face)) * std::sqrt(dot(way, way)));
    storeAcross(found.direction(), normals.data() + 3 * std::size_t{v},
                directions.data() + 3 * std::size_t{v});
  };
  for (std::size_t k = 0; k < 3; ++k) {
    FieldPlace corner;
    corner.kind = FieldPlace::VERTEX;
    corner.a = surface.corner(field.goal_face, k);
    surface.forFacesAt(corner, [&](std::uint32_t face) {
      for (std::size_t i = 0; i < 3 && surface.isGoalIn(face); ++i) {
        if (values.isFinal(surface.corner(face, i))) {
          store(face, surface.corner(face, i));
        }
      }
    });
  }
}

template <bool HAS_COSTS>
void storeAtVertices(const FrontMesh& front, const SurfaceField& field, ArrayView<float> normals,
                     unsigned threads, LargeArray<float>& directions)
{
  parallelFor(front.vertexCount(), CHUNK, threads, [&]() -> RangeBody {
    return [&, values = FieldValues<HAS_COSTS>(field)](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto v = static_cast<std::uint32_t>(i);
        VertexDirection<HAS_COSTS> found(values, front, v);
        if (values.isFinal(v)) {
          found.lookAround();
        }
        storeAcross(found.direction(), normals.data() + 3 * i, directions.data() + 3 * i);
      }
    };
  });
}

}  // namespace

LargeArray<float> vertexDirections(const TraceMesh& mesh, const FrontMesh& front,
                                   const SurfaceField& field, ArrayView<float> normals,
                                   unsigned threads)
{
  if (front.vertexCount() != mesh.mesh.vertexCount() ||
      normals.size() != mesh.mesh.positions.size()) {
    throw std::invalid_argument("the corners or normals are of another mesh");
  }
  LargeArray<float> directions(mesh.mesh.positions.size());
  const bool has_costs = !field.slowness.empty();
  (has_costs ? storeAtVertices<true> : storeAtVertices<false>)(front, field, normals, threads,
                                                               directions);
  const FieldSurface surface(mesh, field);
  if (surface.hasGoal()) {
    (has_costs ? storeAtGoal<true> : storeAtGoal<false>)(surface, front, field, normals,
                                                         directions);
  }
  return directions;
}

}  // namespace mesh_map
