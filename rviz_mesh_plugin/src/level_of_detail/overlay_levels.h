#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/face_bits.h"
#include "base/mesh_data.h"
#include "level_of_detail/mesh_layout.h"

namespace rviz_mesh_plugin {

/// Of a mesh what overlays on many of its faces are drawn by: the parts and simplified levels that
/// the mesh itself is drawn in where its layout is not split, with the vertices of the mesh.
/// Immutable.
struct OverlayLevels
{
  struct Part : Bounds
  {
    std::size_t begin = 0;  ///< of faces
    std::size_t end = 0;
    std::vector<IndexRange> levels;           ///< of indices, with seams; without the full level
    std::vector<std::uint32_t> drawn_beside;  ///< parts that have faces of this one in their seams
  };

  std::vector<std::uint32_t> faces;    ///< of the mesh, part after part
  std::vector<std::uint32_t> part_of;  ///< which part has each face of the mesh
  std::vector<Part> parts;
  std::vector<float> cell_sizes;       ///< of each level, see LayoutOutline; 0 for the full one
  std::vector<std::uint32_t> indices;  ///< of simplified faces, three each: vertices of the mesh
  std::vector<std::uint32_t> owners;   ///< which part each of these faces is of

  /// Those of a mesh, which all share that use them at once. Takes as long as layOut().
  /// @throw Canceled (cancellation.h), std::bad_alloc
  static std::shared_ptr<const OverlayLevels> of(const MeshDataConstPtr& mesh,
                                                 const std::atomic<bool>& canceled);
};
using OverlayLevelsConstPtr = std::shared_ptr<const OverlayLevels>;

/// The faces of one part that are drawn, in all levels.
struct PartFaces
{
  std::size_t part = 0;
  std::vector<std::uint32_t> indices;  ///< three vertices of the mesh per face
  std::vector<IndexRange> levels;      ///< the full one first; none where no face is drawn
  bool whole = false;                  ///< all faces of the part are
};

/// Makes what is drawn of a set of faces that changes: only those parts anew in which a face has
/// come or gone. To be used by one thread at a time.
///
/// Of the full level it is exactly these faces. A simplified face is drawn with the probability of
/// the share that the set has of the faces around its corners, by a number that is always the same
/// for that face: so any set covers as much of the picture as it does in full.
class OverlayFaces
{
 public:
  /// No faces yet. @param levels of the mesh @param drawn parts that are to be made anew
  OverlayFaces(MeshDataConstPtr mesh, OverlayLevelsConstPtr levels,
               const std::vector<std::size_t>& drawn = {});

  const OverlayLevelsConstPtr& levels() const { return levels_; }

  /// From now on it is these faces, of the same mesh.
  void setFaces(FaceBits faces);

  /// The next parts that have changed, at least one, until they have so many bytes; none where all
  /// are as they should be. @throw Canceled, std::bad_alloc: nothing is lost then
  std::vector<PartFaces> next(std::size_t bytes, const std::atomic<bool>& canceled);
  bool isDone() const { return left_ == 0; }

 private:
  /// Of each vertex, while a part is made: how many faces it has there, and how many in the set.
  struct Votes
  {
    std::uint16_t all = 0;
    std::uint16_t in = 0;
  };

  /// @param votes all zero, or none yet, and so again afterwards
  PartFaces make(std::size_t part, std::vector<Votes>& votes) const;
  void change(std::size_t part);
  bool isWhole(std::size_t part) const
  {
    return counts_[part] == levels_->parts[part].end - levels_->parts[part].begin;
  }

  const MeshDataConstPtr mesh_;
  const OverlayLevelsConstPtr levels_;
  FaceBits faces_;
  std::vector<std::size_t> counts_;  ///< of each part: its faces in the set
  std::vector<bool> changed_;        ///< of each part
  std::size_t left_ = 0;             ///< of these
};

}  // namespace rviz_mesh_plugin
