#include "rviz_mesh_plugin/part_materials.h"

#include "rviz_mesh_plugin/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

using Faces = MeshStyle::Faces;

Ogre::ColourValue ogreColor(const Rgba8& color)
{
  return Ogre::ColourValue(color.red, color.green, color.blue, color.alpha) * (1.0f / 255.0f);
}

}  // namespace

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
  FaceLook look;
  look.color = style.faces_color;
  if (style.faces == Faces::HIDDEN) {
    look.from = FaceLook::Color::HIDDEN;
  } else if (style.faces == Faces::VERTEX_COLORS && has_colors) {
    look.from = FaceLook::Color::VERTICES;
    look.translucent = translucent_colors || style.alpha < 1.0f;
    look.one_color_per_face = layout_->split == Split::BY_FACE;
  } else if (textures_drawn_) {
    look.from = FaceLook::Color::PARTS;
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
  look.from = FaceLook::Color::HIDDEN;
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
  FaceLook look;
  look.from = FaceLook::Color::TEXTURE;
  look.color = style_.faces_color;
  look.texture = texture.texture->get();
  look.translucent = style_.alpha < 1.0f || texture.texture->image()->translucent;
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
      (known != textures_.end() && known->second.texture->image() == image)) {
    return;
  }
  Texture texture;
  texture.texture = std::make_unique<MeshTexture>(image);
  textures_[index] = std::move(texture);
  uploading_.insert(index);
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
  texture.material = std::make_unique<MeshMaterial>();
  applyTexture(texture);
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
