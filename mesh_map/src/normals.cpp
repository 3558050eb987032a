#include <mesh_map/normals.h>
#include <mesh_map/parallel.h>

#include <cmath>

namespace mesh_map {
namespace {

constexpr std::size_t ITEMS_PER_CHUNK = 32768;

struct Vector
{
  double x, y, z;

  double norm() const { return std::sqrt(x * x + y * y + z * z); }
};

/// Twice the area of a face along its normal. Differences of floats and their products are exact
/// enough in double that a face far from the origin has the same normal as near it.
Vector areaVector(const MeshView& mesh, std::size_t face)
{
  const std::uint32_t* const corners = mesh.faces.data() + 3 * face;
  const float* const a = mesh.positions.data() + 3 * std::size_t{corners[0]};
  const float* const b = mesh.positions.data() + 3 * std::size_t{corners[1]};
  const float* const c = mesh.positions.data() + 3 * std::size_t{corners[2]};
  const double ux = double{b[0]} - a[0], uy = double{b[1]} - a[1], uz = double{b[2]} - a[2];
  const double vx = double{c[0]} - a[0], vy = double{c[1]} - a[1], vz = double{c[2]} - a[2];
  return {uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx};
}

void store(const Vector& vector, float* normal)
{
  const double norm = vector.norm();
  if (norm > 0.0 && std::isfinite(norm)) {
    normal[0] = static_cast<float>(vector.x / norm);
    normal[1] = static_cast<float>(vector.y / norm);
    normal[2] = static_cast<float>(vector.z / norm);
  } else {
    normal[0] = normal[1] = 0.0f;
    normal[2] = 1.0f;
  }
}

}  // namespace

std::vector<float> faceNormals(const MeshView& mesh, unsigned threads)
{
  std::vector<float> normals(3 * mesh.faceCount());
  parallelFor(mesh.faceCount(), ITEMS_PER_CHUNK, threads, [&mesh, &normals]() -> RangeBody {
    return [mesh, out = normals.data()](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        store(areaVector(mesh, f), out + 3 * f);
      }
    };
  });
  return normals;
}

std::vector<std::uint8_t> facesWithoutArea(const MeshView& mesh, unsigned threads)
{
  std::vector<std::uint8_t> flags(mesh.faceCount());
  parallelFor(mesh.faceCount(), ITEMS_PER_CHUNK, threads, [&mesh, &flags]() -> RangeBody {
    return [mesh, out = flags.data()](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        const double norm = areaVector(mesh, f).norm();
        out[f] = !(norm > 0.0 && std::isfinite(norm));
      }
    };
  });
  return flags;
}

std::vector<float> vertexNormals(ArrayView<float> face_normals, const RowsView& vertex_faces,
                                 ArrayView<std::uint8_t> ignored, unsigned threads)
{
  std::vector<float> normals(3 * vertex_faces.rowCount());
  const auto make_worker = [&]() -> RangeBody {
    return [=, out = normals.data()](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        Vector sum = {0.0, 0.0, 0.0};
        for (std::uint32_t i = vertex_faces.offsets[v]; i < vertex_faces.offsets[v + 1]; ++i) {
          const std::uint32_t face = vertex_faces.values[i];
          if (!ignored.empty() && ignored[face]) {
            continue;
          }
          const float* const normal = face_normals.data() + 3 * std::size_t{face};
          sum.x += normal[0];
          sum.y += normal[1];
          sum.z += normal[2];
        }
        store(sum, out + 3 * v);
      }
    };
  };
  parallelFor(vertex_faces.rowCount(), ITEMS_PER_CHUNK, threads, make_worker);
  return normals;
}

}  // namespace mesh_map
