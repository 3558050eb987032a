#include "mesh/orientation.h"

#include <cmath>

#include "base/require.h"
#include "base/vector3.h"

namespace mesh_map {
namespace {

/// Faces of a patch, each seen with the orientation it has got so far.
class PatchSums
{
 public:
  PatchSums(const MeshView& mesh, const Vector3& up) : mesh_(mesh), up_(up) {}

  void begin(std::uint32_t face)
  {
    origin_ = mesh_.corner(face, 0);
    seen_from_above_ = area_ = volume_ = volume_of_parts_ = 0.0;
  }

  void add(std::uint32_t face, bool turned)
  {
    const float* const a = mesh_.corner(face, 0);
    const Vector3 normal = triangleNormal(a, mesh_.corner(face, 1), mesh_.corner(face, 2));
    const double sign = turned ? -1.0 : 1.0;
    seen_from_above_ += sign * dot(normal, up_);
    area_ += norm(normal);
    const double volume = dot(difference(a, origin_), normal);
    volume_ += sign * volume;
    volume_of_parts_ += std::abs(volume);
  }

  bool isUpsideDown() const
  {
    constexpr double nothing = 1e-6;
    if (std::abs(seen_from_above_) > nothing * area_) {
      return seen_from_above_ < 0.0;
    }
    return volume_ < -nothing * volume_of_parts_;
  }

 private:
  MeshView mesh_;
  Vector3 up_;
  const float* origin_ = nullptr;
  double seen_from_above_ = 0.0, area_ = 0.0, volume_ = 0.0, volume_of_parts_ = 0.0;
};

bool isDegenerate(const std::uint32_t* face)
{
  return face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
}

constexpr const char* OTHER_TOPOLOGY = "the topology is not that of the faces";

/// For each edge of two faces, these.
std::vector<std::uint32_t> facesOfEdges(ArrayView<std::uint32_t> faces,
                                        ArrayView<std::uint32_t> face_edges,
                                        ArrayView<std::uint32_t> edge_face_counts)
{
  std::vector<std::uint32_t> result(2 * edge_face_counts.size(), NO_INDEX);
  for (std::size_t slot = 0; slot < faces.size(); ++slot) {
    const std::size_t face = slot / 3, edge = face_edges[slot];
    if (isDegenerate(faces.data() + 3 * face)) {
      continue;
    }
    require(edge < edge_face_counts.size(), OTHER_TOPOLOGY);
    if (edge_face_counts[edge] == 2) {
      std::uint32_t* const pair = result.data() + 2 * edge;
      require(pair[1] == NO_INDEX, OTHER_TOPOLOGY);
      pair[pair[0] != NO_INDEX] = static_cast<std::uint32_t>(face);
    }
  }
  for (std::size_t edge = 0; edge < edge_face_counts.size(); ++edge) {
    require((edge_face_counts[edge] == 2) == (result[2 * edge + 1] != NO_INDEX), OTHER_TOPOLOGY);
  }
  return result;
}

}  // namespace

Orientation orientFaces(const MeshView& mesh, ArrayView<std::uint32_t> face_edges,
                        ArrayView<std::uint32_t> edge_face_counts,
                        ArrayView<std::uint8_t> edge_flags, const std::array<double, 3>& up)
{
  constexpr std::uint8_t not_seen = 2;
  const std::vector<std::uint32_t> edge_faces =
      facesOfEdges(mesh.faces, face_edges, edge_face_counts);
  Orientation result;
  result.turned.assign(mesh.faceCount(), not_seen);
  result.patches.assign(mesh.faceCount(), NO_INDEX);
  std::uint8_t* const turned = result.turned.data();
  PatchSums sums(mesh, up);
  std::vector<std::uint32_t> patch;
  std::size_t conflicting_sides = 0;
  for (std::uint32_t start = 0; start < mesh.faceCount(); ++start) {
    if (isDegenerate(mesh.faces.data() + 3 * std::size_t{start})) {
      turned[start] = 0;
    }
    if (turned[start] != not_seen) {
      continue;
    }
    ++result.patch_count;
    patch.assign(1, start);
    turned[start] = 0;
    sums.begin(start);
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const std::uint32_t face = patch[i];
      result.patches[face] = static_cast<std::uint32_t>(result.patch_count - 1);
      sums.add(face, turned[face] != 0);
      for (unsigned k = 0; k < 3; ++k) {
        const std::size_t edge = face_edges[3 * std::size_t{face} + k];
        const std::uint32_t* const pair = edge_faces.data() + 2 * edge;
        if (pair[0] == NO_INDEX) {
          continue;
        }
        const std::uint32_t other = pair[pair[0] == face];
        const bool disagree = (edge_flags[edge] & EDGE_INCONSISTENT) != 0;
        const std::uint8_t wanted = (turned[face] != 0) != disagree;
        if (turned[other] == not_seen) {
          turned[other] = wanted;
          patch.push_back(other);
        } else {
          conflicting_sides += turned[other] != wanted;
        }
      }
    }
    if (sums.isUpsideDown()) {
      for (const std::uint32_t face : patch) {
        turned[face] ^= 1;
      }
    }
  }
  result.conflicts = conflicting_sides / 2;
  return result;
}

}  // namespace mesh_map
