#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <OgrePrerequisites.h>

#include "level_of_detail/mesh_layout.h"
#include "rendering/masked_parts.h"
#include "rendering/mesh_buffers.h"
#include "rendering/mesh_material.h"
#include "rendering/mesh_part_object.h"
#include "rendering/mesh_style.h"
#include "rendering/placed_visual.h"
#include "rendering/vertex_colors.h"

namespace rviz_mesh_plugin {

/// Everything that OGRE holds of one layout: buffers, colors, materials, textures, and the parts.
/// Uploaded in slices; the rest of the layout is let go then. Not visible at first. GUI thread
/// only.
class GpuMesh : public PlacedVisual
{
 public:
  GpuMesh(Ogre::SceneNode* parent, const MeshLayoutConstPtr& layout,
          std::size_t indices_per_buffer);

  const LayoutOutlineConstPtr& layout() const { return layout_; }

  /// Uploads one slice; false where nothing was left to do.
  bool uploadSlice();
  /// It would take about as long as all slices of one frame.
  bool nextSliceIsLong() const
  {
    return buffers_ &&
           (buffers_->nextSliceIsLong() || (buffers_->complete() && materials_.nextSliceIsLong()));
  }

  /// The coarsest level of detail can be drawn, in its colors if there are any.
  bool drawable() const;
  bool geometryComplete() const { return !buffers_ || buffers_->complete(); }
  /// The part of vertices and faces that is uploaded, 0..1.
  float progress() const;

  void setStyle(const MeshStyle& style);
  void setColors(const ColorSource& colors, bool translucent);
  void updateColors(const ColorSource& colors, const std::vector<std::uint32_t>& changed);
  void clearColors();
  void setTexture(const TextureImageConstPtr& image);
  void clearTextures();

  /// Takes these faces of the mesh out of what is drawn, see MaskedParts.
  void hide(const HiddenFacesConstPtr& hidden) { masks_.hide(hidden); }
  /// Nothing is drawn of them any more.
  bool isHiddenComplete() const { return masks_.isComplete(); }
  /// As uploadSlice(), of that alone.
  bool uploadHiddenSlice() { return buffers_ && masks_.uploadSlice(); }

  std::size_t colorUploads() const { return colors_.uploads(); }
  std::size_t gpuBytes() const;
  const std::vector<std::unique_ptr<MeshPartObject>>& parts() const { return parts_; }

 private:
  void makeParts();
  void applyStyle();
  void assignMaterials();

  LayoutOutlineConstPtr layout_;
  std::unique_ptr<MeshBuffers> buffers_;  ///< null where there is nothing to draw
  VertexColors colors_;
  Ogre::HardwareVertexBufferSharedPtr bound_colors_;
  PartMaterials materials_;
  MeshStyle style_;
  bool colors_turn_ = true;  ///< else that of faces, where both are left to upload
  PartDrawing drawing_;
  std::size_t coarsest_end_ = 0;  ///< of the indices of all parts' coarsest levels
  std::vector<std::unique_ptr<MeshPartObject>> parts_;
  MaskedParts masks_;
};

}  // namespace rviz_mesh_plugin
