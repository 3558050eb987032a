#include <mesh_map/field_trace.h>
#include <mesh_map/parallel.h>

#include <cstddef>
#include <cstdint>

#include "field_values.h"

namespace mesh_map {
namespace {

/// Faces that a thread takes at once.
constexpr std::size_t CHUNK = 8192;

/// From where the labels of all three corners say that the source lies: the point of the plane for
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
  const float* const at = mesh.positions.data() + 3 * std::size_t{v[0]};
  const Vector3 p = difference(mesh.positions.data() + 3 * std::size_t{v[1]}, at);
  const Vector3 q = difference(mesh.positions.data() + 3 * std::size_t{v[2]}, at);
  const double pp = dot(p, p), pq = dot(p, q), qq = dot(q, q), area = pp * qq - pq * pq;
  if (!(area > NO_AREA * pp * qq)) {
    return;
  }
  const double per_square = HAS_COSTS ? 1.0 / (scale * scale) : 1.0;
  const double u[3] = {values.label(v[0]), values.label(v[1]), values.label(v[2])};
  const double along_p = pp - (u[1] - u[0]) * (u[1] + u[0]) * per_square;
  const double along_q = qq - (u[2] - u[0]) * (u[2] + u[0]) * per_square;
  // As weights of p and q, times twice the squared area; less what leads to the middle.
  const double middle = area * (2.0 / 3.0);
  const double to_p = qq * along_p - pq * along_q - middle;
  const double to_q = pp * along_q - pq * along_p - middle;
  storeUnit({to_p * p[0] + to_q * q[0], to_p * p[1] + to_q * q[1], to_p * p[2] + to_q * q[2]}, 0.0,
            out);
}

template <bool HAS_COSTS>
void storeAtFaces(const MeshView& mesh, const SurfaceField& field, unsigned threads,
                  LargeArray<float>& directions)
{
  parallelFor(mesh.faceCount(), CHUNK, threads, [&]() -> RangeBody {
    return [&, values = FieldValues<HAS_COSTS>(field)](std::size_t begin, std::size_t end) {
      for (std::size_t face = begin; face < end; ++face) {
        storeAtFace(values, mesh, face, directions.data() + 3 * face);
      }
    };
  });
}

}  // namespace

LargeArray<float> faceDirections(const TraceMesh& mesh, const SurfaceField& field, unsigned threads)
{
  LargeArray<float> directions(mesh.mesh.faces.size());
  (field.slowness.empty() ? storeAtFaces<false> : storeAtFaces<true>)(mesh.mesh, field, threads,
                                                                      directions);
  return directions;
}

}  // namespace mesh_map
