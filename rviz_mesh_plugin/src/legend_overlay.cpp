#include "legend_overlay.h"

#include <stdexcept>

#include <OgreHardwarePixelBuffer.h>
#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>
#include <OgreTextureManager.h>
#include <Overlay/OgreOverlay.h>
#include <Overlay/OgreOverlayContainer.h>
#include <Overlay/OgreOverlayManager.h>

#include "picture_material.h"
#include "rviz_mesh_plugin/ogre_compatibility.h"
#include "rviz_mesh_plugin/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

/// Below what other plugins put there on purpose (OGRE allows 0 to 650).
constexpr unsigned short Z_ORDER = 300;

}  // namespace

LegendOverlay::LegendOverlay()
{
  Ogre::OverlayManager* manager = Ogre::OverlayManager::getSingletonPtr();
  if (!manager) {
    throw std::runtime_error("OGRE has been set up without overlays");
  }
  try {
    material_ = createPictureMaterial("Legend material");
    element_ = static_cast<Ogre::OverlayContainer*>(
        manager->createOverlayElement("Panel", uniqueName("Legend panel")));
    element_->setMetricsMode(Ogre::GMM_PIXELS);
    element_->setHorizontalAlignment(Ogre::GHA_RIGHT);
    element_->setMaterialName(material_->getName());
    overlay_ = manager->create(uniqueName("Legend"));
    overlay_->setZOrder(Z_ORDER);
    overlay_->add2D(element_);
  } catch (...) {
    destroy();
    throw;
  }
}

LegendOverlay::~LegendOverlay()
{
  destroy();
}

void LegendOverlay::destroy()
{
  if (Ogre::OverlayManager* manager = Ogre::OverlayManager::getSingletonPtr()) {
    if (overlay_) {
      manager->destroy(overlay_);
    }
    if (element_) {
      manager->destroyOverlayElement(element_);
    }
  }
  overlay_ = nullptr;
  element_ = nullptr;
  removeResource(Ogre::MaterialManager::getSingleton(), material_);
  removeResource(Ogre::TextureManager::getSingleton(), texture_);
}

void LegendOverlay::setPicture(const QImage& picture)
{
  if (!isSet(texture_) || picture.width() != width_ || picture.height() != height_) {
    Ogre::Pass* pass = material_->getTechnique(0)->getPass(0);
    pass->removeAllTextureUnitStates();
    removeResource(Ogre::TextureManager::getSingleton(), texture_);
    width_ = picture.width();
    height_ = picture.height();
    texture_ = Ogre::TextureManager::getSingleton().createManual(
        uniqueName("Legend texture"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME,
        Ogre::TEX_TYPE_2D, static_cast<Ogre::uint>(width_), static_cast<Ogre::uint>(height_), 0,
        Ogre::PF_A8R8G8B8, Ogre::TU_STATIC_WRITE_ONLY);
    Ogre::TextureUnitState* unit = pass->createTextureUnitState(texture_->getName());
    unit->setTextureFiltering(Ogre::TFO_NONE);
    unit->setTextureAddressingMode(Ogre::TextureUnitState::TAM_CLAMP);
    element_->setDimensions(static_cast<float>(width_), static_cast<float>(height_));
  }
  // Rows of this format are never padded. OGRE only reads.
  const Ogre::PixelBox box(static_cast<Ogre::uint32>(width_), static_cast<Ogre::uint32>(height_), 1,
                           Ogre::PF_A8R8G8B8, const_cast<uchar*>(picture.constBits()));
  texture_->getBuffer()->blitFromMemory(box);
}

void LegendOverlay::setPosition(int right, int top)
{
  element_->setPosition(static_cast<float>(-right - width_), static_cast<float>(top));
}

void LegendOverlay::setVisible(bool visible)
{
  if (visible) {
    overlay_->show();
  } else {
    overlay_->hide();
  }
}

}  // namespace rviz_mesh_plugin
