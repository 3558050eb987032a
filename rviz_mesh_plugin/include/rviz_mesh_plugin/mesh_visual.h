#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <OgrePrerequisites.h>
#include <OgreQuaternion.h>

#include "rviz_mesh_plugin/mesh_data.h"
#include "rviz_mesh_plugin/mesh_style.h"
#include "rviz_mesh_plugin/ogre_compatibility.h"

namespace rviz_mesh_plugin {

class MeshMaterial;
class MeshObject;

/// Draws one mesh with OGRE below a scene node of its own. GUI thread only.
///
/// Vertices and faces are uploaded once per setGeometry(), colors once per setColors(); a change of
/// style uploads nothing. Everything created is destroyed with the visual.
class MeshVisual
{
 public:
  MeshVisual(Ogre::SceneManager* scene_manager, Ogre::SceneNode* parent);
  ~MeshVisual();
  MeshVisual(const MeshVisual&) = delete;
  MeshVisual& operator=(const MeshVisual&) = delete;

  /// Replaces the mesh; colors are gone. The visual keeps the data, for the lines of the normals.
  void setGeometry(const MeshDataConstPtr& mesh);

  /// One color per vertex of the mesh. @throw std::invalid_argument where the number is another
  /// one.
  void setColors(const std::vector<Rgba8>& colors);
  void clearColors();

  void setStyle(const MeshStyle& style);

  /// Pose of the mesh's frame in the fixed frame.
  void setPose(const Ogre::Vector3& position, const Ogre::Quaternion& orientation);
  void setVisible(bool visible);

  /// How often vertices and faces, and how often colors, went to the graphics card.
  std::size_t geometryUploads() const { return geometry_uploads_; }
  std::size_t colorUploads() const { return color_uploads_; }

 private:
  void applyStyle();
  void updateNormals();

  Ogre::SceneManager* scene_manager_;
  Ogre::SceneNode* parent_;
  Ogre::SceneNode* node_;
  MeshStyle style_;
  MeshDataConstPtr mesh_;
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
