#include "mesh/normals.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <cmath>

#include "base/fixed_point.h"
#include "base/vector3.h"

namespace mesh_map {
namespace {

constexpr std::size_t ITEMS_PER_CHUNK = 32768;

/// False where there is no direction: that of the fallback is stored.
bool store(const Vector3& vector, const std::array<float, 3>& fallback, float* normal)
{
  const double length = norm(vector);
  const bool good = length > 0.0 && std::isfinite(length);
  for (unsigned axis = 0; axis < 3; ++axis) {
    normal[axis] = good ? static_cast<float>(vector[axis] / length) : fallback[axis];
  }
  return good;
}

}  // namespace

FaceNormals faceNormals(const MeshView& mesh, const std::array<float, 3>& fallback)
{
  FaceNormals result;
  result.normals.resize(3 * mesh.faceCount());
  result.without_area.resize(mesh.faceCount());
  const auto one = [mesh, fallback, out = result.normals.data(),
                    flags = result.without_area.data()](std::size_t f) {
    const Vector3 normal = triangleNormal(mesh.corner(f, 0), mesh.corner(f, 1), mesh.corner(f, 2));
    flags[f] = !store(normal, fallback, out + 3 * f);
  };
  parallelEach(mesh.faceCount(), ITEMS_PER_CHUNK, 0, one);
  return result;
}

std::vector<float> cornerAngles(const MeshView& mesh)
{
  std::vector<float> angles(3 * mesh.faceCount());
  const auto one = [mesh, out = angles.data()](std::size_t f) {
    const Vector3 ab = difference(mesh.corner(f, 1), mesh.corner(f, 0)),
                  ac = difference(mesh.corner(f, 2), mesh.corner(f, 0)), bc = ac - ab;
    out[3 * f] = static_cast<float>(angleBetween(ab, ac));
    out[3 * f + 1] = static_cast<float>(angleBetween(-ab, bc));
    out[3 * f + 2] = static_cast<float>(angleBetween(ac, bc));  // both turned round
  };
  parallelEach(mesh.faceCount(), ITEMS_PER_CHUNK, 0, one);
  return angles;
}

std::vector<float> vertexNormals(const VertexNormalsInput& input)
{
  std::vector<float> normals(3 * input.vertex_faces.rowCount());
  const auto one = [in = input, out = normals.data()](std::size_t v) {
    const std::uint32_t* const offsets = in.vertex_faces.offsets.data();
    Vector3 sum{};
    for (std::uint32_t i = offsets[v]; i < offsets[v + 1]; ++i) {
      const std::size_t face = in.vertex_faces.values[i];
      if (in.ignored[face]) {
        continue;
      }
      // by angle: G. Thuermer, C. Wuethrich: Computing Vertex Normals from Polygonal Facets, 1998
      double weight = 1.0;
      if (!in.corner_angles.empty()) {
        const std::uint32_t* const corners = in.faces.data() + 3 * face;
        const unsigned k = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
        weight = in.corner_angles[3 * face + k];
      }
      sum = sum + weight * pointOf(in.face_normals.data() + 3 * face);
    }
    store(sum, in.fallback, out + 3 * v);
  };
  parallelEach(input.vertex_faces.rowCount(), ITEMS_PER_CHUNK, 0, one);
  return normals;
}

namespace {

/// arcsin(sqrt(z)) / sqrt(z) for z up to 0.5, as a polynomial that is off by 2^-53 at most (by
/// Chebyshev interpolation): a loop with it is vectorized, which one with std::asin is not.
[[gnu::always_inline]] inline double arcSineOfRoot(double z)
{
  const double z2 = z * z, z4 = z2 * z2, z8 = z4 * z4;
  const double first = (1.0 + 0.16666666666666963 * z) +
                       (0.074999999999212 + 0.044642857225603634 * z) * z2 +
                       ((0.03038193986011071 + 0.022372313869349934 * z) +
                        (0.017349295408732632 + 0.014019395590469537 * z) * z2) *
                           z4;
  const double second = (0.010926915350699614 + 0.015111539062223301 * z) +
                        (-0.026437715003228238 + 0.18152875115124464 * z) * z2 +
                        ((-0.6661897214747655 + 2.0073335321918253 * z) +
                         (-4.547862686114816 + 7.787133449193568 * z) * z2) *
                            z4;
  const double third = (-9.691180967536004 + 8.341634059380597 * z) +
                       (-4.446674648447561 + 1.128125499336932 * z) * z2;
  return first + (second + third * z8) * z8;
}

/// By a quarter of the squared chord.
[[gnu::always_inline]] inline double angleOfChord(double z)
{
  return 2.0 * std::sqrt(z) * arcSineOfRoot(z);
}

}  // namespace

double angleBetween(const float* a, const float* b)
{
  const Vector3 chord = pointOf(a) - pointOf(b);
  const double squared = dot(chord, chord);
  // The half of the circle in which the arc sine is well conditioned.
  if (squared <= 2.0) {
    return angleOfChord(0.25 * squared);
  }
  const Vector3 opposite = pointOf(a) + pointOf(b);
  return PI - angleOfChord(0.25 * dot(opposite, opposite));
}

std::vector<float> meanEdgeAngles(ArrayView<float> normals, ArrayView<std::uint32_t> edges,
                                  const RowsView& neighbor_edges)
{
  std::vector<std::uint32_t> angles(edges.size() / 2);
  parallelEach(angles.size(), ITEMS_PER_CHUNK, 0, [=, out = angles.data()](std::size_t e) {
    out[e] = toFixed(angleBetween(normals.data() + 3 * std::size_t{edges[2 * e]},
                                  normals.data() + 3 * std::size_t{edges[2 * e + 1]}),
                     ANGLE_UNITS);
  });
  std::vector<float> means(neighbor_edges.rowCount());
  parallelEach(means.size(), ITEMS_PER_CHUNK, 0,
               [rows = neighbor_edges, from = angles.data(), out = means.data()](std::size_t v) {
                 const std::uint32_t* const offsets = rows.offsets.data();
                 std::uint64_t sum = 0;
                 for (std::uint32_t k = offsets[v]; k < offsets[v + 1]; ++k) {
                   sum += from[rows.values[k]];
                 }
                 out[v] = meanOfFixed(sum, ANGLE_UNITS, offsets[v + 1] - offsets[v]);
               });
  return means;
}

namespace {

/// Angles between normals and a direction. Inlined where it is compiled for a kind of processor;
/// the numbers are the same on all.
[[gnu::always_inline]] inline void storeAngles(const float* normals, std::size_t count,
                                               const float* direction, float* angles)
{
  const Vector3 to = pointOf(direction);
  for (std::size_t v = 0; v < count; ++v) {
    const Vector3 normal = pointOf(normals + 3 * v), chord = normal - to, opposite = normal + to;
    const double squared = dot(chord, chord), others = dot(opposite, opposite);
    // As angleBetween(), without a branch.
    const bool is_acute = squared <= 2.0;
    const double angle = angleOfChord(0.25 * (is_acute ? squared : others));
    angles[v] = static_cast<float>(is_acute ? angle : PI - angle);
  }
}

using StoreAngles = void (*)(const float*, std::size_t, const float*, float*);

void storeAnglesBase(const float* normals, std::size_t count, const float* direction, float* angles)
{
  storeAngles(normals, count, direction, angles);
}

#ifdef __x86_64__

[[gnu::target("avx2")]] void storeAnglesAvx2(const float* normals, std::size_t count,
                                             const float* direction, float* angles)
{
  storeAngles(normals, count, direction, angles);
}

StoreAngles storeAnglesHere()
{
  return __builtin_cpu_supports("avx2") ? storeAnglesAvx2 : storeAnglesBase;
}

#else

StoreAngles storeAnglesHere()
{
  return storeAnglesBase;
}

#endif

}  // namespace

std::vector<float> anglesTo(ArrayView<float> normals, const std::array<double, 3>& direction)
{
  // As precise as the normals are: then one that is the same as the direction has the angle 0.
  const std::array<float, 3> to = {static_cast<float>(direction[0]),
                                   static_cast<float>(direction[1]),
                                   static_cast<float>(direction[2])};
  std::vector<float> angles(normals.size() / 3);
  parallelFor(angles.size(), ITEMS_PER_CHUNK, 0, [&]() -> RangeBody {
    return [from = normals.data(), to, out = angles.data(), store = storeAnglesHere()](
               std::size_t begin, std::size_t end) {
      store(from + 3 * begin, end - begin, to.data(), out + begin);
    };
  });
  return angles;
}

}  // namespace mesh_map
