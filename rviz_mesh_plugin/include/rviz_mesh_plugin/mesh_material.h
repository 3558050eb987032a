#pragma once

#include <OgreColourValue.h>
#include <OgreMaterial.h>
#include <OgrePrerequisites.h>
#include <OgreTexture.h>

#include "rviz_mesh_plugin/mesh_style.h"

namespace rviz_mesh_plugin {

/// What the faces of one material look like, besides what is common to all of a mesh (MeshStyle).
struct FaceLook
{
  enum class Color
  {
    HIDDEN,
    ONE,       ///< color
    VERTICES,  ///< of the vertex buffer
    PARTS,     ///< each MeshPartObject has its own
    TEXTURE    ///< texture
  };

  Color from = Color::ONE;
  Ogre::ColourValue color;
  bool translucent = false;
  bool one_color_per_face = false;  ///< VERTICES: that of the last vertex
  Ogre::TexturePtr texture;
};

/// An OGRE material of a mesh: a pass for the faces, lit from both sides, and a pass for the
/// wireframe.
///
/// Its first technique uses GLSL programs. Where the OpenGL driver has none, OGRE falls back to the
/// second one of fixed function: front faces lit, back faces in their color without light; parts
/// have no color of their own there (color is used), vertex colors no other alpha than theirs.
class MeshMaterial
{
 public:
  MeshMaterial();
  ~MeshMaterial();
  MeshMaterial(const MeshMaterial&) = delete;
  MeshMaterial& operator=(const MeshMaterial&) = delete;

  void apply(const MeshStyle& style, const FaceLook& look);

  /// One color without light, for lines.
  void applyUnlit(const Ogre::ColourValue& color);

  const Ogre::MaterialPtr& get() const { return material_; }

 private:
  Ogre::MaterialPtr material_;
};

}  // namespace rviz_mesh_plugin
