#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include <OgrePrerequisites.h>

#include "base/mesh_data.h"
#include "coloring/color_source.h"
#include "level_of_detail/mesh_layout.h"
#include "rendering/mesh_buffers.h"
#include "rendering/mesh_style.h"
#include "rendering/placed_visual.h"

namespace rviz_mesh_plugin {

class MeshMaterial;
class GpuMesh;

/// Draws one mesh with OGRE in the pose of its frame. GUI thread only.
///
/// Uploads go in slices through upload(), so that the GUI is never blocked for long: first the
/// coarse levels of detail, then the finer ones. Colors are uploaded apart from vertices and faces;
/// a change of style uploads nothing. Small meshes are uploaded at once. Everything created is
/// destroyed with the visual.
class MeshVisual : public PlacedVisual
{
 public:
  explicit MeshVisual(Ogre::SceneNode* parent, std::size_t indices_per_buffer = INDICES_PER_BUFFER);
  ~MeshVisual();

  /// Replaces the mesh. What is drawn before stays until the coarsest level of the new one can be
  /// drawn in its colors: those of before, where it is a layout of the same mesh (and both are
  /// split BY_FACE or both are not); else those of setColors(), to be called before upload().
  /// @throw Ogre::Exception, std::bad_alloc: then what is drawn before stays
  void setLayout(const MeshLayoutConstPtr& layout);
  /// Of the one set last; null before the first.
  const LayoutOutlineConstPtr& layout() const { return layout_; }
  /// Of the one that is drawn now: that one, or the one before while it is not uploaded yet.
  const LayoutOutlineConstPtr& shownLayout() const { return shown_layout_; }

  /// Uploads for about this long, at least one slice (right behind setLayout() perhaps none); true
  /// where nothing is left to do.
  /// @throw Ogre::Exception, std::bad_alloc; what was being uploaded is given up
  bool upload(std::chrono::microseconds budget = std::chrono::milliseconds(15));

  /// The part of vertices and faces that has been uploaded, 0..1.
  float progress() const;

  /// Colors all vertices (BY_FACE: faces) anew, through upload(), and those of later layouts of the
  /// same mesh (see setLayout()). Colors that are being uploaded are shown first; of those that
  /// come in the meantime the last ones are next. Needs a layout.
  /// @param translucent whether a color may have an alpha below 255
  void setColors(const ColorSource& colors, bool translucent);
  /// Goes on with another source, which differs in the colors of these vertices (BY_FACE: faces) of
  /// the mesh alone.
  void updateColors(const ColorSource& colors, const std::vector<std::uint32_t>& changed);
  /// Frees them; faces are drawn in MeshStyle::faces_color.
  void clearColors();

  /// For a layout split BY_MATERIAL; textures may come in any order, and are not drawn any more
  /// with another layout and by clearTextures(), but are freed with their images. Until one is
  /// uploaded, its faces have the color of their material.
  void setTexture(const TextureImageConstPtr& image);
  void clearTextures();

  /// Takes these faces of the mesh (null: none) out of what is drawn, through upload(), within a
  /// moment; to be followed by a layout without them, which is drawn in less detail where that is
  /// far. What a layout does not have is not drawn either way.
  void hide(const HiddenFacesConstPtr& hidden);
  /// Whether nothing is drawn of these.
  bool hides(const HiddenFacesConstPtr& hidden) const;

  void setStyle(const MeshStyle& style);

  /// How often vertices and faces, and how often all colors, went to the graphics card.
  std::size_t geometryUploads() const { return geometry_uploads_; }
  std::size_t colorUploads() const { return color_uploads_; }

  /// Faces of all parts in the levels of detail that they were last drawn in, in view or not.
  std::size_t facesDrawn() const;

  /// In buffers and textures of the graphics card.
  std::size_t gpuBytes() const;

 private:
  class NormalLines;
  GpuMesh* newest() const { return coming_ ? coming_.get() : shown_.get(); }
  bool uploadSlice();
  void uploadIfSmall();
  void showComing();
  void updateNormals();

  std::size_t indices_per_buffer_;
  MeshStyle style_;
  LayoutOutlineConstPtr layout_;
  LayoutOutlineConstPtr shown_layout_;
  std::weak_ptr<const MeshLayout> given_;  ///< that layout_ is the outline of
  std::unique_ptr<GpuMesh> shown_;
  std::unique_ptr<GpuMesh> coming_;  ///< of layout_, until it is drawable
  HiddenFacesConstPtr hidden_;       ///< of the mesh
  ColorSource colors_;
  bool translucent_colors_ = false;
  std::unique_ptr<MeshMaterial> normals_material_;
  std::unique_ptr<NormalLines> normals_;  ///< only while shown
  MeshDataConstPtr normals_mesh_;         ///< that normals_ has been built of
  HiddenFacesConstPtr normals_hidden_;    ///< that it has been built without
  float normals_length_ = 0.0f;           ///< that normals_ has been built with
  bool fresh_ = false;                    ///< setLayout() has been called since the last upload()
  std::size_t geometry_uploads_ = 0;
  std::size_t color_uploads_ = 0;
};

}  // namespace rviz_mesh_plugin
