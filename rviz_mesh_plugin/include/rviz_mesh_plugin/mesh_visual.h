#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include <OgrePrerequisites.h>
#include <OgreQuaternion.h>

#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/mesh_layout.h"
#include "rviz_mesh_plugin/mesh_style.h"
#include "rviz_mesh_plugin/ogre_compatibility.h"

namespace rviz_mesh_plugin {

class MeshMaterial;
class MeshObject;

/// Gives the colors of some vertices or faces of the mesh (MeshLayout::sources). Called in slices
/// on the GUI thread, also much later: it owns what it reads.
using ColorSource =
    std::function<void(const std::uint32_t* sources, std::size_t count, Rgba8* colors)>;

/// Draws one mesh with OGRE below a scene node of its own. GUI thread only.
///
/// Uploads go in slices through upload(), so that the GUI is never blocked for long: first the
/// coarse levels of detail, then the finer ones. Colors are uploaded apart from vertices and faces;
/// a change of style uploads nothing. Everything created is destroyed with the visual.
class MeshVisual
{
 public:
  MeshVisual(Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent);
  ~MeshVisual();
  MeshVisual(const MeshVisual&) = delete;
  MeshVisual& operator=(const MeshVisual&) = delete;

  /// Replaces the mesh. What is drawn before stays until the coarsest level of the new one can be
  /// drawn in the same colors.
  void setLayout(const MeshLayoutConstPtr& layout);
  const MeshLayoutConstPtr& layout() const { return layout_; }

  /// Uploads for about this long, at least one slice; true where nothing is left to do.
  bool upload(std::chrono::microseconds budget = std::chrono::milliseconds(15));

  /// The part of vertices and faces that has been uploaded, 0..1.
  float progress() const;

  /// Colors all vertices (BY_FACE: faces) anew, now and after each setLayout() of the same split.
  /// @param translucent whether a color may have an alpha below 255
  void setColors(const ColorSource& colors, bool translucent);
  /// Asks the same source again for these vertices (BY_FACE: faces) of the mesh alone.
  void updateColors(const std::vector<std::uint32_t>& changed);
  void clearColors();

  /// For layouts split BY_MATERIAL; textures may come in any order, and are freed with the layout
  /// and by clearTextures().
  void setTexture(const TextureImageConstPtr& image);
  void clearTextures();

  void setStyle(const MeshStyle& style);

  /// Pose of the mesh's frame in the fixed frame.
  void setPose(const Ogre::Vector3& position, const Ogre::Quaternion& orientation);
  void setVisible(bool visible);

  /// How often vertices and faces, and how often all colors, went to the graphics card.
  std::size_t geometryUploads() const { return geometry_uploads_; }
  std::size_t colorUploads() const { return color_uploads_; }

 private:
  void applyStyle();
  void updateNormals();

  Ogre::SceneManager* scene_manager_;
  Ogre::SceneNode* parent_;
  Ogre::SceneNode* node_;
  MeshStyle style_;
  MeshLayoutConstPtr layout_;
  ColorSource colors_;
  std::unique_ptr<MeshMaterial> material_;
  std::unique_ptr<MeshObject> faces_;
  std::unique_ptr<MeshMaterial> normals_material_;
  std::unique_ptr<MeshObject> normals_;  ///< only while shown
  float normals_length_ = 0.0f;          ///< that normals_ has been built with
  bool visible_ = true;
  bool translucent_colors_ = false;
  std::size_t geometry_uploads_ = 0;
  std::size_t color_uploads_ = 0;
};

}  // namespace rviz_mesh_plugin
