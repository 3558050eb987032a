#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>

#include <OgreColourValue.h>
#include <OgreMaterial.h>

#include "level_of_detail/mesh_layout.h"
#include "rendering/mesh_style.h"
#include "rendering/mesh_texture.h"
#include "rendering/two_sided_lighting.h"

namespace rviz_mesh_plugin {

Ogre::ColourValue ogreColor(const Rgba8& color);

/// An OGRE material of a mesh: a pass for the faces, lit from both sides, and a pass for the
/// wireframe.
///
/// Its first technique uses GLSL programs. Where the OpenGL driver has none, OGRE falls back to the
/// second one of fixed function: front faces lit, back faces in their color without light; parts
/// have no color of their own there (color is used), vertex colors no other alpha than theirs, and
/// nothing is cut.
class MeshMaterial
{
 public:
  MeshMaterial();
  ~MeshMaterial();
  MeshMaterial(const MeshMaterial&) = delete;
  MeshMaterial& operator=(const MeshMaterial&) = delete;

  /// @param look of the faces; culling and wireframe are those of the style
  void apply(const MeshStyle& style, const SurfaceLook& look);

  /// One color without light, for lines.
  void applyUnlit(const Ogre::ColourValue& color, const Section& section);

  /// One color, lit as meshes are and drawn just in front of the faces it lies on; without programs
  /// all the light is its own.
  void applyOverlay(const Ogre::ColourValue& color, const Section& section);

  const Ogre::MaterialPtr& get() const { return material_; }

 private:
  Ogre::MaterialPtr material_;
};

/// The OGRE materials and textures of one layout: one for all parts or, where these have materials
/// of their own (Split::BY_MATERIAL), one for all without a texture and one per texture. GUI thread
/// only.
class PartMaterials
{
 public:
  explicit PartMaterials(const LayoutOutlineConstPtr& layout);

  /// Rebuilds the materials; callers assign them to the parts then.
  /// @param has_colors, translucent_colors of the vertex buffer
  void apply(const MeshStyle& style, bool has_colors, bool translucent_colors);

  /// Null where nothing of the part is drawn.
  Ogre::MaterialPtr of(const MeshPart& part) const;
  /// What MeshPartObject::setColor() takes.
  Ogre::ColourValue colorOf(const MeshPart& part) const;

  /// An image that no material refers to is left out.
  void setTexture(const TextureImageConstPtr& image);
  void clearTextures();
  bool complete() const { return uploading_.empty(); }
  /// True where a texture has become complete: apply() shows it.
  bool uploadSlice();
  /// It would take about as long as all slices of one frame.
  bool nextSliceIsLong() const;

  std::size_t bytes() const;

 private:
  struct Texture
  {
    std::shared_ptr<MeshTexture> texture;
    std::unique_ptr<MeshMaterial> material;  ///< once the texture is complete
  };

  /// Null where the part has none.
  const Material* materialOf(const MeshPart& part) const;
  void applyTexture(const Texture& texture) const;
  void makeMaterial(Texture& texture) const;

  LayoutOutlineConstPtr layout_;
  MeshStyle style_;
  bool textures_drawn_ = false;
  std::set<std::uint32_t> used_textures_;
  std::map<std::uint32_t, Texture> textures_;
  std::set<std::uint32_t> uploading_;
  MeshMaterial opaque_;                        ///< of all parts without a texture
  std::unique_ptr<MeshMaterial> translucent_;  ///< of parts with a translucent color
  std::unique_ptr<MeshMaterial> lines_only_;   ///< of parts whose faces are left out
};

}  // namespace rviz_mesh_plugin
