#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/face_bits.h"
#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

class SelectableFaces;

/// The corners of all faces, where vertices in the same place are one and the same.
std::vector<std::uint32_t> joinedCorners(const MeshData& mesh);

/// Which faces of a mesh lie beside each other: those that share an edge, also where each has
/// vertices of its own there (as at the seams of textures): corners are the same where their
/// coordinates are. An edge may have any number of faces. A face with two corners in the same place
/// has no neighbors. Immutable: for any threads at once.
class FaceNeighbors
{
 public:
  using Faces = FaceBits::Faces;

  /// Takes about a second for some million faces.
  /// @param corners of joinedCorners(), three per face
  /// @throw Canceled (cancellation.h), std::invalid_argument, std::bad_alloc
  explicit FaceNeighbors(const std::vector<std::uint32_t>& corners,
                         const std::atomic<bool>* cancel = nullptr);

  std::size_t faceCount() const { return sides_.size() / 3; }

  /// The ring around a selection: its neighbors that are not in it, ascending. Takes about 10 ms
  /// per million selected faces. @throw Canceled, std::bad_alloc
  Faces grow(const FaceBits& selection, const std::atomic<bool>* cancel = nullptr) const;

  /// The outermost ring of a selection: its faces that have a neighbor that is not in it,
  /// ascending. (Where the mesh ends, there is no neighbor.) @throw Canceled, std::bad_alloc
  Faces shrink(const FaceBits& selection, const std::atomic<bool>* cancel = nullptr) const;

  /// The connected region around a face, ascending: from face to neighbor wherever their normals
  /// differ by at most this angle. Faces without area belong to it, and nothing is reached through
  /// them.
  /// @param mesh that this has been made of
  /// @param max_angle in radians
  /// @param selectable what of the mesh it may be of; null: all
  /// @param open only faces among these are reached, or gone through; null: all
  /// @throw Canceled, std::bad_alloc
  Faces flood(const MeshData& mesh, std::uint32_t start, double max_angle,
              const SelectableFaces* selectable = nullptr, const FaceBits* open = nullptr,
              const std::atomic<bool>* cancel = nullptr) const;

 private:
  template <class Visit>
  void visit(std::uint32_t face, const Visit& visit) const;
  Faces border(const FaceBits& selection, bool selected, const std::atomic<bool>* cancel) const;

  /// Three per face: its neighbor there, NONE, or SHARED and the number of a row of shared_.
  std::vector<std::uint32_t> sides_;
  /// Rows of the faces at edges that have more than two.
  std::vector<std::uint32_t> shared_offsets_;
  std::vector<std::uint32_t> shared_;
};

}  // namespace rviz_mesh_plugin
