#include "rendering/labels/label_material.h"

#include <algorithm>

#include "base/erase_if.h"

namespace rviz_mesh_plugin {

void LabelMaterial::setAlpha(float alpha)
{
  alpha_ = std::clamp(alpha, 0.0f, 1.0f);
  apply();
}

void LabelMaterial::setSection(const Section& section)
{
  section_ = section;
  apply();
}

void LabelMaterial::apply()
{
  Ogre::ColourValue color = ogreColor(color_);
  color.a *= alpha_;
  translucent_ = color.a < 1.0f;
  material_.applyOverlay(color, section_);
}

std::shared_ptr<LabelMaterial> LabelMaterials::get(const Rgba8& color)
{
  if (materials_.size() >= clean_at_) {
    eraseIf(materials_, [](const auto& entry) { return entry.second.expired(); });
    clean_at_ = std::max<std::size_t>(64, 2 * materials_.size());
  }
  auto& known = materials_[{color.red, color.green, color.blue, color.alpha}];
  std::shared_ptr<LabelMaterial> material = known.lock();
  if (!material) {
    material = std::make_shared<LabelMaterial>(color, section_);
    material->setAlpha(alpha_);
    known = material;
  }
  return material;
}

void LabelMaterials::setAlpha(float alpha)
{
  alpha_ = alpha;
  for (const auto& entry : materials_) {
    if (const auto material = entry.second.lock()) {
      material->setAlpha(alpha);
    }
  }
}

void LabelMaterials::setSection(const Section& section)
{
  if (section == section_) {
    return;
  }
  section_ = section;
  for (const auto& entry : materials_) {
    if (const auto material = entry.second.lock()) {
      material->setSection(section);
    }
  }
}

}  // namespace rviz_mesh_plugin
