#include "rendering/mesh_material.h"

#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>
#include <OgreTextureUnitState.h>

#include "rendering/ogre/ogre_compatibility.h"
#include "rendering/ogre/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

/// Lines and overlays are pulled this far in front of the faces they lie in (units of the depth
/// buffer; slope of the face).
constexpr float DEPTH_BIAS = 1.0f;
constexpr float SLOPE_BIAS = 1.0f;

/// Draws in one color without light.
void setUnlitColor(Ogre::Pass* pass, const Ogre::ColourValue& color)
{
  // Without lighting OGRE takes the color of the vertices: light is on, but all the light is the
  // surface's own.
  pass->setLightingEnabled(true);
  pass->setAmbient(Ogre::ColourValue::Black);
  pass->setDiffuse(Ogre::ColourValue(0.0f, 0.0f, 0.0f, color.a));
  pass->setSpecular(Ogre::ColourValue::Black);
  pass->setSelfIllumination(color);
}

/// Translucent passes blend with what is behind them and leave the depth buffer alone.
void setBlending(Ogre::Pass* pass, bool translucent)
{
  pass->setSceneBlending(translucent ? Ogre::SBT_TRANSPARENT_ALPHA : Ogre::SBT_REPLACE);
  pass->setDepthWriteEnabled(!translucent);
}

Ogre::CullingMode cullingMode(MeshStyle::Culling culling)
{
  switch (culling) {
    case MeshStyle::Culling::BACK:
      return Ogre::CULL_CLOCKWISE;
    case MeshStyle::Culling::FRONT:
      return Ogre::CULL_ANTICLOCKWISE;
    default:
      return Ogre::CULL_NONE;
  }
}

void addTexture(Ogre::Pass* pass, const SurfaceLook& look)
{
  if (look.from == SurfaceLook::Color::TEXTURE) {
    Ogre::TextureUnitState* unit = pass->createTextureUnitState(look.texture->getName());
    unit->setTextureFiltering(Ogre::TFO_TRILINEAR);
  }
}

Ogre::Pass* addProgramFaces(Ogre::Technique* technique, MeshStyle::Culling culling,
                            const SurfaceLook& look)
{
  Ogre::Pass* pass = technique->createPass();
  setTwoSidedLighting(pass, look);
  pass->setCullingMode(cullingMode(culling));
  // Without programs, this would make the light flat, too.
  pass->setShadingMode(look.one_color_per_face ? Ogre::SO_FLAT : Ogre::SO_GOURAUD);
  setBlending(pass, look.translucent);
  addTexture(pass, look);
  return pass;
}

/// One side of the faces.
void addFixedFunctionSide(Ogre::Technique* technique, bool front, const SurfaceLook& look)
{
  Ogre::Pass* pass = technique->createPass();
  pass->setCullingMode(front ? Ogre::CULL_CLOCKWISE : Ogre::CULL_ANTICLOCKWISE);
  const bool flat = look.flat_shading || look.one_color_per_face;
  pass->setShadingMode(flat ? Ogre::SO_FLAT : Ogre::SO_GOURAUD);
  setBlending(pass, look.translucent);
  addTexture(pass, look);
  if (look.from == SurfaceLook::Color::VERTICES) {
    pass->setLightingEnabled(front);
    pass->setVertexColourTracking(Ogre::TVC_DIFFUSE);
    return;
  }
  Ogre::ColourValue color =
      look.from == SurfaceLook::Color::TEXTURE ? Ogre::ColourValue::White : look.color;
  color.a = look.from == SurfaceLook::Color::ONE ? look.color.a : look.alpha;
  setUnlitColor(pass, front ? color * AMBIENT_SHARE : color);
  Ogre::ColourValue diffuse =
      front ? color * (1.0f - AMBIENT_SHARE) : Ogre::ColourValue(0.0f, 0.0f, 0.0f);
  diffuse.a = color.a;
  pass->setDiffuse(diffuse);
}

void addFixedFunctionFaces(Ogre::Technique* technique, MeshStyle::Culling culling,
                           const SurfaceLook& look)
{
  if (culling != MeshStyle::Culling::BACK) {
    addFixedFunctionSide(technique, false, look);
  }
  if (culling != MeshStyle::Culling::FRONT) {
    addFixedFunctionSide(technique, true, look);
  }
}

Ogre::Pass* addUnlit(Ogre::Technique* technique, const Ogre::ColourValue& color)
{
  Ogre::Pass* pass = technique->createPass();
  setUnlitColor(pass, color);
  setBlending(pass, color.a < 1.0f);
  return pass;
}

/// In a technique with programs.
void cut(Ogre::Pass* pass, const Ogre::ColourValue& color, const Section& section)
{
  if (section.cuts()) {
    setUnlitSection(pass, color, section);
  }
}

void addWireframe(Ogre::Technique* technique, const MeshStyle& style, bool programs)
{
  Ogre::Pass* pass = addUnlit(technique, style.wireframe_color);
  if (programs) {
    cut(pass, style.wireframe_color, style.section);
  }
  pass->setPolygonMode(Ogre::PM_WIREFRAME);
  pass->setCullingMode(cullingMode(style.culling));
  pass->setDepthBias(DEPTH_BIAS, SLOPE_BIAS);
}

using Faces = MeshStyle::Faces;

/// In one color.
SurfaceLook lookOf(const MeshStyle& style)
{
  SurfaceLook look;
  look.color = style.faces_color;
  look.alpha = style.alpha;
  look.flat_shading = style.flat_shading;
  look.contour_interval = style.contour_interval;
  look.section = style.section;
  return look;
}

}  // namespace

Ogre::ColourValue ogreColor(const Rgba8& color)
{
  return Ogre::ColourValue(color.red, color.green, color.blue, color.alpha) * (1.0f / 255.0f);
}

MeshMaterial::MeshMaterial()
    : material_(Ogre::MaterialManager::getSingleton().create(
          uniqueName("Material"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME))
{
  material_->setReceiveShadows(false);
}

MeshMaterial::~MeshMaterial()
{
  removeResource(Ogre::MaterialManager::getSingleton(), material_);
}

void MeshMaterial::apply(const MeshStyle& style, const SurfaceLook& look)
{
  material_->removeAllTechniques();
  for (const bool programs : {true, false}) {
    Ogre::Technique* technique = material_->createTechnique();
    if (look.from != SurfaceLook::Color::HIDDEN) {
      if (programs) {
        addProgramFaces(technique, style.culling, look);
      } else {
        addFixedFunctionFaces(technique, style.culling, look);
      }
    }
    if (style.show_wireframe) {
      addWireframe(technique, style, programs);
    }
    if (technique->getNumPasses() == 0) {
      technique->createPass();  // OGRE refuses a technique without any
    }
  }
}

void MeshMaterial::applyUnlit(const Ogre::ColourValue& color, const Section& section)
{
  material_->removeAllTechniques();
  cut(addUnlit(material_->createTechnique(), color), color, section);
  addUnlit(material_->createTechnique(), color);
}

void MeshMaterial::applyOverlay(const Ogre::ColourValue& color, const Section& section)
{
  SurfaceLook look;
  look.color = color;
  look.translucent = color.a < 1.0f;
  look.overlay = true;
  look.section = section;
  material_->removeAllTechniques();
  for (Ogre::Pass* pass :
       {addProgramFaces(material_->createTechnique(), MeshStyle::Culling::NONE, look),
        addUnlit(material_->createTechnique(), color)}) {
    pass->setDepthBias(DEPTH_BIAS, SLOPE_BIAS);
    pass->setCullingMode(Ogre::CULL_NONE);
  }
}

PartMaterials::PartMaterials(const LayoutOutlineConstPtr& layout) : layout_(layout)
{
  if (layout->materials) {
    for (const Material& material : layout->materials->materials) {
      used_textures_.insert(material.texture_index);
    }
    used_textures_.erase(NONE);
  }
}

const Material* PartMaterials::materialOf(const MeshPart& part) const
{
  const bool known = layout_->materials && part.material < layout_->materials->materials.size();
  return known ? &layout_->materials->materials[part.material] : nullptr;
}

void PartMaterials::apply(const MeshStyle& style, bool has_colors, bool translucent_colors)
{
  style_ = style;
  textures_drawn_ = style.faces == Faces::TEXTURES && layout_->split == Split::BY_MATERIAL;
  translucent_.reset();
  lines_only_.reset();
  SurfaceLook look = lookOf(style);
  if (style.faces == Faces::HIDDEN) {
    look.from = SurfaceLook::Color::HIDDEN;
  } else if (style.faces == Faces::VERTEX_COLORS && has_colors) {
    look.from = SurfaceLook::Color::VERTICES;
    look.translucent = translucent_colors || style.alpha < 1.0f;
    look.one_color_per_face = layout_->split == Split::BY_FACE;
  } else if (textures_drawn_) {
    look.from = SurfaceLook::Color::PARTS;
    look.translucent = style.alpha < 1.0f;
  } else {
    look.translucent = look.color.a < 1.0f;
  }
  opaque_.apply(style, look);
  if (!textures_drawn_) {
    return;
  }
  look.translucent = true;
  translucent_ = std::make_unique<MeshMaterial>();
  translucent_->apply(style, look);
  look.from = SurfaceLook::Color::HIDDEN;
  lines_only_ = std::make_unique<MeshMaterial>();
  lines_only_->apply(style, look);
  for (auto& texture : textures_) {
    if (texture.second.material) {
      applyTexture(texture.second);
    }
  }
}

void PartMaterials::applyTexture(const Texture& texture) const
{
  SurfaceLook look = lookOf(style_);
  look.from = SurfaceLook::Color::TEXTURE;
  look.texture = texture.texture->get();
  look.translucent = style_.alpha < 1.0f || texture.texture->translucent();
  texture.material->apply(style_, look);
}

Ogre::MaterialPtr PartMaterials::of(const MeshPart& part) const
{
  if (!textures_drawn_) {
    const bool nothing = style_.faces == Faces::HIDDEN && !style_.show_wireframe;
    return nothing ? Ogre::MaterialPtr() : opaque_.get();
  }
  const Material* material = materialOf(part);
  if (style_.only_textured && (!material || material->texture_index == NONE)) {
    return style_.show_wireframe ? lines_only_->get() : Ogre::MaterialPtr();
  }
  if (material) {
    const auto texture = textures_.find(material->texture_index);
    if (texture != textures_.end() && texture->second.material) {
      return texture->second.material->get();
    }
  }
  return (colorOf(part).a < 1.0f ? *translucent_ : opaque_).get();
}

Ogre::ColourValue PartMaterials::colorOf(const MeshPart& part) const
{
  const Material* material = materialOf(part);
  return material ? ogreColor(material->color) : style_.faces_color;
}

void PartMaterials::setTexture(const TextureImageConstPtr& image)
{
  const std::uint32_t index = image->index;
  const auto known = textures_.find(index);
  if (layout_->split != Split::BY_MATERIAL || used_textures_.count(index) == 0 ||
      (known != textures_.end() && known->second.texture == image->uploaded)) {
    return;
  }
  Texture texture;
  texture.texture = MeshTexture::of(*image);
  const bool complete = texture.texture->complete();  // as where the mesh is only laid out anew
  textures_[index] = std::move(texture);
  if (complete) {
    makeMaterial(textures_[index]);
  } else {
    uploading_.insert(index);
  }
}

void PartMaterials::makeMaterial(Texture& texture) const
{
  texture.material = std::make_unique<MeshMaterial>();
  applyTexture(texture);
}

bool PartMaterials::nextSliceIsLong() const
{
  return !uploading_.empty() && textures_.at(*uploading_.begin()).texture->nextSliceIsLong();
}

void PartMaterials::clearTextures()
{
  textures_.clear();
  uploading_.clear();
}

bool PartMaterials::uploadSlice()
{
  if (uploading_.empty()) {
    return false;
  }
  Texture& texture = textures_[*uploading_.begin()];
  texture.texture->uploadSlice();
  if (!texture.texture->complete()) {
    return false;
  }
  uploading_.erase(uploading_.begin());
  makeMaterial(texture);
  return true;
}

std::size_t PartMaterials::bytes() const
{
  std::size_t sum = 0;
  for (const auto& texture : textures_) {
    sum += texture.second.texture->bytes();
  }
  return sum;
}

}  // namespace rviz_mesh_plugin
