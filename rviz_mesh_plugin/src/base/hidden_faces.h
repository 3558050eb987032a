#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/face_bits.h"
#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Faces of a mesh that are not seen, on demand: they are not drawn, and cannot be pointed at or
/// selected. For any thread.
class HiddenFaces
{
 public:
  /// Takes some milliseconds per million faces of the mesh. @throw std::bad_alloc
  explicit HiddenFaces(FaceBits faces);

  const FaceBits& bits() const { return bits_; }
  bool contains(std::uint32_t face) const { return bits_.contains(face); }
  std::size_t count() const { return count_; }
  /// Of each face of the mesh: 0 where it is hidden, else 1; for mesh_map::RayOptions.
  const std::vector<std::uint8_t>& mask() const { return mask_; }

 private:
  FaceBits bits_;
  std::size_t count_;
  std::vector<std::uint8_t> mask_;
};
/// Null: none is hidden.
using HiddenFacesConstPtr = std::shared_ptr<const HiddenFaces>;

/// What tells a mesh, also when it comes once more, as after Reset, from others.
struct MeshKey
{
  MeshKey(const MeshData& mesh)
      : uuid(mesh.uuid), vertex_count(mesh.vertexCount()), face_count(mesh.faceCount())
  {
  }

  std::string uuid;
  std::size_t vertex_count;
  std::size_t face_count;
};
bool operator==(const MeshKey& a, const MeshKey& b);

/// So many meshes may have hidden faces; of more, those are shown again that were hidden first.
constexpr std::size_t MOST_MESHES_WITH_HIDDEN_FACES = 16;

/// Those of a mesh, in all displays of this process. For any thread.
HiddenFacesConstPtr hiddenFaces(const MeshKey& mesh);
/// @param hidden of a mesh of as many faces; null, or none in it: all are shown
/// @throw std::invalid_argument for those of another mesh
void setHiddenFaces(const MeshKey& mesh, HiddenFacesConstPtr hidden);
/// Another one after each change.
std::uint64_t hiddenFacesRevision();

/// The faces that are shown: the same list where none is hidden. @param faces of the mesh
std::shared_ptr<const FaceBits::Faces> withoutHidden(
    const std::shared_ptr<const FaceBits::Faces>& faces, const HiddenFacesConstPtr& hidden);

}  // namespace rviz_mesh_plugin
