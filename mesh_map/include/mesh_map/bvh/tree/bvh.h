#pragma once

#include <mesh_map/base/array_view.h>
#include <mesh_map/base/large_array.h>
#include <mesh_map/base/run_options.h>
#include <mesh_map/bvh/tree/bvh_node.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mesh_map {

/// A bounding volume hierarchy over the triangles of a mesh: what answers geometric questions. It
/// owns a copy of the triangles, so the mesh may go. Immutable but for refit(), so several threads
/// may query at once. Queries are in bvh_rays.h, bvh_closest.h and bvh_selection.h.
///
/// Every query answers as if it had looked at every face in double precision.
class Bvh
{
 public:
  /// Throws std::invalid_argument for a mesh without faces or with too many (2^31), a face that
  /// refers to no vertex, or a corner that is not finite (naming the first), Canceled, or
  /// std::bad_alloc. Nothing is left behind then. Vertices that no face has do not matter.
  static Bvh build(const MeshView& mesh, const BvhOptions& options = {});

  /// The same tree over moved vertices of the same faces. Throws as build(); then nothing has
  /// changed. No query may run meanwhile.
  void refit(const MeshView& mesh, const BvhOptions& options = {});

  /// Bytes from which deserialize() makes the same hierarchy again, on machines of any byte order.
  std::vector<std::uint8_t> serialize() const;

  /// Throws std::invalid_argument for bytes that are damaged, of another version, or not of this
  /// mesh. What it accepts is safe to query: every index and range is checked.
  static Bvh deserialize(ArrayView<std::uint8_t> bytes, const MeshView& mesh);

  /// Node 0 is the root.
  ArrayView<BvhNode> nodes() const { return {nodes_.data(), nodes_.size()}; }

  /// Per triangle, in the order of the leaves: x, y, z of its three corners, as in the mesh. Some
  /// floats more may be read behind the end (TAIL of them).
  ArrayView<float> corners() const { return {corners_.data(), 9 * faces_.size()}; }
  static constexpr std::size_t TAIL = 32;

  /// Per triangle: its index in the mesh.
  ArrayView<std::uint32_t> faces() const { return {faces_.data(), faces_.size()}; }
  std::size_t faceCount() const { return faces_.size(); }

  /// Origin of the local coordinates of the boxes. It lies among the triangles, so that boxes are
  /// small numbers also where the mesh is far from its own origin.
  const std::array<float, 3>& center() const { return center_; }

  /// Box around everything, in local coordinates.
  const std::array<float, 3>& lower() const { return lower_; }
  const std::array<float, 3>& upper() const { return upper_; }

  /// Bytes held.
  std::size_t memory() const;

 private:
  Bvh() = default;
  friend class BvhBuilder;
  void setBox();

  LargeArray<BvhNode> nodes_;
  LargeArray<float> corners_;
  LargeArray<std::uint32_t> faces_;
  std::array<float, 3> center_{}, lower_{}, upper_{};
};

}  // namespace mesh_map
