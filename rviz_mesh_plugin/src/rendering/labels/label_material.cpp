#include "rendering/labels/label_material.h"

#include <algorithm>

#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>

#include "rendering/ogre_compatibility.h"
#include "rendering/two_sided_lighting.h"
#include "rendering/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

/// Labels are pulled this far in front of the faces they lie on, as the wireframe is (units of the
/// depth buffer; slope of the face).
constexpr float DEPTH_BIAS = 1.0f;
constexpr float SLOPE_BIAS = 1.0f;

Ogre::Pass* addPass(Ogre::Technique* technique, bool translucent)
{
  Ogre::Pass* pass = technique->createPass();
  pass->setSceneBlending(translucent ? Ogre::SBT_TRANSPARENT_ALPHA : Ogre::SBT_REPLACE);
  pass->setDepthWriteEnabled(!translucent);
  pass->setDepthBias(DEPTH_BIAS, SLOPE_BIAS);
  pass->setCullingMode(Ogre::CULL_NONE);
  return pass;
}

std::uint32_t keyOf(const Rgba8& color)
{
  return static_cast<std::uint32_t>(color.red) << 24 |
         static_cast<std::uint32_t>(color.green) << 16 |
         static_cast<std::uint32_t>(color.blue) << 8 | color.alpha;
}

}  // namespace

LabelMaterial::LabelMaterial(const Rgba8& color)
    : color_(color),
      material_(Ogre::MaterialManager::getSingleton().create(
          uniqueName("Label material"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME))
{
  material_->setReceiveShadows(false);
  setAlpha(1.0f);
}

LabelMaterial::~LabelMaterial()
{
  removeResource(Ogre::MaterialManager::getSingleton(), material_);
}

void LabelMaterial::setAlpha(float alpha)
{
  const Ogre::ColourValue color(color_.red / 255.0f, color_.green / 255.0f, color_.blue / 255.0f,
                                color_.alpha / 255.0f * std::max(0.0f, std::min(alpha, 1.0f)));
  translucent_ = color.a < 1.0f;
  material_->removeAllTechniques();
  SurfaceColor surface;
  surface.color = color;
  setTwoSidedLighting(addPass(material_->createTechnique(), translucent_), surface);
  // Without programs: all the light is the surface's own.
  Ogre::Pass* pass = addPass(material_->createTechnique(), translucent_);
  pass->setAmbient(Ogre::ColourValue::Black);
  pass->setDiffuse(Ogre::ColourValue(0.0f, 0.0f, 0.0f, color.a));
  pass->setSelfIllumination(color);
}

std::shared_ptr<LabelMaterial> LabelMaterials::get(const Rgba8& color)
{
  if (materials_.size() >= clean_at_) {
    for (auto it = materials_.begin(); it != materials_.end();) {
      it = it->second.expired() ? materials_.erase(it) : std::next(it);
    }
    clean_at_ = std::max<std::size_t>(64, 2 * materials_.size());
  }
  std::weak_ptr<LabelMaterial>& known = materials_[keyOf(color)];
  std::shared_ptr<LabelMaterial> material = known.lock();
  if (!material) {
    material = std::make_shared<LabelMaterial>(color);
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

}  // namespace rviz_mesh_plugin
