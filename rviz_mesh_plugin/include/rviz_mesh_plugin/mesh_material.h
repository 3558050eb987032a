#pragma once

#include <OgreMaterial.h>
#include <OgrePrerequisites.h>

#include "rviz_mesh_plugin/mesh_style.h"

namespace rviz_mesh_plugin {

/// The OGRE material of one mesh: a pass for the faces, lit from both sides, and a pass for the
/// wireframe.
///
/// Its first technique uses GLSL programs. Where the OpenGL driver has none, OGRE falls back to the
/// second one of fixed function: front faces lit, back faces in their color without light.
class MeshMaterial
{
 public:
  MeshMaterial();
  ~MeshMaterial();
  MeshMaterial(const MeshMaterial&) = delete;
  MeshMaterial& operator=(const MeshMaterial&) = delete;

  /// @param has_vertex_colors whether there are any, and @a blend_vertex_colors whether one of them
  /// is translucent
  void apply(const MeshStyle& style, bool has_vertex_colors, bool blend_vertex_colors);

  /// One color without light, for lines.
  void applyUnlit(const Ogre::ColourValue& color);

  const Ogre::MaterialPtr& get() const { return material_; }

 private:
  Ogre::MaterialPtr material_;
};

}  // namespace rviz_mesh_plugin
