#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>

#include <OgreMaterial.h>
#include <OgrePrerequisites.h>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// An OGRE material in one color, lit as meshes are and drawn just in front of them. Destroyed with
/// its last user.
class LabelMaterial
{
 public:
  explicit LabelMaterial(const Rgba8& color);
  ~LabelMaterial();
  LabelMaterial(const LabelMaterial&) = delete;
  LabelMaterial& operator=(const LabelMaterial&) = delete;

  /// Multiplies the alpha of the color.
  void setAlpha(float alpha);
  bool isTranslucent() const { return translucent_; }
  const Ogre::MaterialPtr& get() const { return material_; }

 private:
  Rgba8 color_;
  bool translucent_ = false;
  Ogre::MaterialPtr material_;
};

/// One material for all labels of a color.
class LabelMaterials
{
 public:
  std::shared_ptr<LabelMaterial> get(const Rgba8& color);
  void setAlpha(float alpha);

 private:
  float alpha_ = 1.0f;
  std::map<std::uint32_t, std::weak_ptr<LabelMaterial>> materials_;
  std::size_t clean_at_ = 64;
};

}  // namespace rviz_mesh_plugin
