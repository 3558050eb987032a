#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/hidden_faces.h"
#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// Which faces share their vertices, and so the colors and texture coordinates of these.
enum class Split
{
  NONE,         ///< as in the mesh
  BY_MATERIAL,  ///< faces of different materials share no vertex
  BY_FACE       ///< the last vertex of each face is its own: drawn flat, each face has its color
};

/// A part of the index buffer.
struct IndexRange
{
  std::uint32_t start = 0;
  std::uint32_t count = 0;
  /// Right behind them in coarser levels: faces of other parts beside this one. They close the
  /// gaps to neighbors that are drawn in more detail.
  std::uint32_t seam_count = 0;

  std::size_t end() const { return std::size_t{start} + count + seam_count; }
};

/// A part has at most this many faces.
constexpr std::size_t PART_FACES = 8192;

/// What is culled and drawn at once: faces near to each other that have the same material.
/// Its bounds are those of all levels without seams.
struct MeshPart : Bounds
{
  std::uint32_t material = NONE;  ///< BY_MATERIAL: index into Materials::materials
  /// One range per level of detail, the full one first.
  std::vector<IndexRange> levels;
  std::vector<std::uint32_t> drawn_beside;  ///< parts that have faces of this one in their seams
};

/// What is kept of a layout as long as it is drawn.
struct LayoutOutline
{
  MeshDataConstPtr mesh;
  MaterialsConstPtr materials;  ///< BY_MATERIAL
  Split split = Split::NONE;
  bool preview = false;        ///< a coarse picture of the mesh, soon to be replaced
  HiddenFacesConstPtr hidden;  ///< faces of the mesh that are left out; null: none

  /// What each vertex has its color from: a vertex of the mesh; BY_FACE: a face of the mesh.
  std::vector<std::uint32_t> sources;
  /// Of each level, in meters: faces smaller than this have been merged. 0 for the full level.
  std::vector<float> cell_sizes;
  std::vector<MeshPart> parts;
  /// Of each face of the full level, which one of the mesh it is; null where it is split, and of a
  /// preview.
  std::shared_ptr<const std::vector<std::uint32_t>> faces;
};
using LayoutOutlineConstPtr = std::shared_ptr<const LayoutOutline>;

/// A mesh as it lies in the buffers of the graphics card: sorted in space, cut into parts, with
/// simplified levels of detail that use the same vertices.
struct MeshLayout : LayoutOutline
{
  std::vector<MeshVertex> vertices;
  std::vector<std::array<float, 2>> texture_coordinates;  ///< BY_MATERIAL, where there are any
  std::vector<std::uint32_t> indices;  ///< three per face; the coarsest level first
};
using MeshLayoutConstPtr = std::shared_ptr<const MeshLayout>;

/// Meshes with more faces than this get a preview first; those with less are laid out within a
/// second. Only tests change it.
extern std::atomic<std::size_t> preview_threshold;

/// Takes about 0.25 s per million faces, on two cores.
/// @param materials needed for BY_MATERIAL
/// @param canceled where it becomes true, null is returned soon
/// @param hidden faces that are left out; null: none
/// @throw std::invalid_argument where the materials belong to another mesh
MeshLayoutConstPtr layOut(const MeshDataConstPtr& mesh, Split split,
                          const MaterialsConstPtr& materials, const std::atomic<bool>& canceled,
                          const HiddenFacesConstPtr& hidden = nullptr);

/// A coarse picture of a large mesh, made in a fraction of the time; not split. Null where it
/// would save nothing: where the mesh has few faces for its size.
MeshLayoutConstPtr layOutPreview(const MeshDataConstPtr& mesh);

}  // namespace rviz_mesh_plugin
