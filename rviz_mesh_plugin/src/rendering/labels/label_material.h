#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>

#include "base/mesh_data.h"
#include "rendering/mesh_material.h"

namespace rviz_mesh_plugin {

/// A material in one color, lit as meshes are and drawn just in front of them.
class LabelMaterial
{
 public:
  explicit LabelMaterial(const Rgba8& color, const Section& section = Section())
      : color_(color), section_(section)
  {
    setAlpha(1.0f);
  }

  /// Multiplies the alpha of the color.
  void setAlpha(float alpha);
  /// What is drawn of what has the material.
  void setSection(const Section& section);
  bool isTranslucent() const { return translucent_; }
  const Ogre::MaterialPtr& get() const { return material_.get(); }

 private:
  void apply();

  const Rgba8 color_;
  Section section_;
  float alpha_ = 1.0f;
  bool translucent_ = false;
  MeshMaterial material_;
};

/// One material for all labels of a color.
class LabelMaterials
{
 public:
  std::shared_ptr<LabelMaterial> get(const Rgba8& color);
  void setAlpha(float alpha);
  void setSection(const Section& section);
  const Section& section() const { return section_; }

 private:
  float alpha_ = 1.0f;
  Section section_;
  std::map<std::array<std::uint8_t, 4>, std::weak_ptr<LabelMaterial>> materials_;
  std::size_t clean_at_ = 64;
};

}  // namespace rviz_mesh_plugin
