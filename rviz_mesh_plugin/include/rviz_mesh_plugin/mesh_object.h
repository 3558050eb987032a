#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <OgreAxisAlignedBox.h>
#include <OgreHardwareVertexBuffer.h>
#include <OgreMaterial.h>
#include <OgreMesh.h>
#include <OgrePrerequisites.h>
#include <OgreRenderOperation.h>

#include "rviz_mesh_plugin/mesh_data.h"

namespace rviz_mesh_plugin {

/// Owns one OGRE mesh with its buffers and the entity that draws it, all with unique names;
/// destroys them all.
class MeshObject
{
 public:
  MeshObject(Ogre::SceneManager* scene_manager, Ogre::RenderOperation::OperationType operation);
  ~MeshObject();
  MeshObject(const MeshObject&) = delete;
  MeshObject& operator=(const MeshObject&) = delete;

  /// Uploads @a count vertices: 3 floats of position each and, where @a has_normals, 3 of normal.
  void setVertices(const void* data, std::size_t count, bool has_normals);

  /// Uploads 32-bit indices. Without any, the vertices are drawn in their order.
  void setIndices(const std::vector<std::uint32_t>& indices);

  /// Makes the entity, once, after the vertices and indices.
  void finish(const Ogre::AxisAlignedBox& bounds, const Ogre::MaterialPtr& material);

  /// Draws at this node from now on, nowhere if it is null.
  void attachTo(Ogre::SceneNode* node);

  /// Uploads one color per vertex into a buffer of its own; vertices and indices are not touched.
  void setColors(const std::vector<Rgba8>& colors);

  /// Frees the buffer of the colors.
  void clearColors();

  bool hasColors() const;

 private:
  Ogre::SceneManager* scene_manager_;
  Ogre::MeshPtr mesh_;
  Ogre::Entity* entity_ = nullptr;
  Ogre::HardwareVertexBufferSharedPtr color_buffer_;
};

}  // namespace rviz_mesh_plugin
