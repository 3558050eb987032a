#include "conversion/geometry_remark.h"

#include <mesh_map/base/parallel.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "base/status_lines.h"
#include "base/vectors.h"

namespace rviz_mesh_plugin {
namespace {

/// Of larger meshes, the median edge is that of about so many faces, evenly spread.
constexpr std::size_t MEDIAN_FACES = 100000;
constexpr double TOLERATED = 0.1;  ///< of the median edge
/// Faces that one core looks at at a time.
constexpr std::size_t FACES_AT_A_TIME = 65536;

float farthest(const MeshData& mesh)
{
  float most = 0.0f;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    most = std::max({most, -mesh.lower[axis], mesh.upper[axis]});
  }
  return most;
}

/// Half of the step between neighboring numbers: by so much float32 may be beside the number.
double roundingAt(float coordinate)
{
  return 0.5 * (double(std::nextafter(coordinate, std::numeric_limits<float>::max())) -
                double(coordinate));
}

/// In meters, of the edges that have a length; 0 where none has.
double medianEdge(const mesh_msgs::MeshGeometry& geometry)
{
  const std::size_t stride = geometry.faces.size() / MEDIAN_FACES + 1;
  std::vector<double> lengths;
  lengths.reserve(3 * (geometry.faces.size() / stride + 1));
  for (std::size_t face = 0; face < geometry.faces.size(); face += stride) {
    const auto& corners = geometry.faces[face].vertex_indices;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& a = geometry.vertices[corners[i]];
      const auto& b = geometry.vertices[corners[(i + 1) % 3]];
      const double length = Eigen::Vector3d(b.x - a.x, b.y - a.y, b.z - a.z).norm();
      if (length > 0.0) {
        lengths.push_back(length);
      }
    }
  }
  if (lengths.empty()) {
    return 0.0;
  }
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

/// Not one face is as large as a point or a line at least.
bool hasNoArea(const MeshData& mesh)
{
  std::atomic<bool> found{false};
  mesh_map::parallelFor(mesh.faceCount(), FACES_AT_A_TIME, 0, [&]() -> mesh_map::RangeBody {
    return [&](std::size_t begin, std::size_t end) {
      for (std::size_t face = begin; face < end && !found; ++face) {
        if (normalOf(mesh, static_cast<std::uint32_t>(face)).squaredNorm() > 0.0) {
          found = true;
        }
      }
    };
  });
  return !found;
}

}  // namespace

std::string findRemark(const mesh_msgs::MeshGeometry& geometry, const MeshData& mesh)
{
  const float far = farthest(mesh);
  const double rounding = roundingAt(far);
  const double edge = medianEdge(geometry);
  if (edge > 0.0 && rounding > TOLERATED * edge) {
    return joined("coordinates up to ", far, " m are drawn with an error of up to ", rounding,
                  " m, more than a tenth of the median edge (", edge,
                  " m), so that the picture is distorted: publish the mesh in a frame with a "
                  "nearer origin");
  }
  if (mesh.lower == mesh.upper) {
    return joined("all ", mesh.vertexCount(), " vertices lie in one point, (", mesh.lower[0], ", ",
                  mesh.lower[1], ", ", mesh.lower[2],
                  "), so that nothing can be seen: look at the unit and the source of the mesh");
  }
  if (hasNoArea(mesh)) {
    return joined("all ", counted(mesh.faceCount(), "face", "faces"),
                  " are degenerate, their corners in one point or on one line, so that nothing can "
                  "be seen: look at the vertex indices and the source of the mesh");
  }
  return std::string();
}

}  // namespace rviz_mesh_plugin
