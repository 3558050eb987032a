#pragma once

#include <string>

#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreTechnique.h>

#include "rendering/ogre/unique_name.h"

namespace rviz_mesh_plugin {

/// Of what is drawn over the picture: in its own colors, translucent ones blended.
inline Ogre::MaterialPtr createPictureMaterial(const std::string& name)
{
  Ogre::MaterialPtr material = Ogre::MaterialManager::getSingleton().create(
      uniqueName(name), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME);
  material->setReceiveShadows(false);
  Ogre::Pass* pass = material->getTechnique(0)->getPass(0);
  pass->setLightingEnabled(false);
  pass->setDepthCheckEnabled(false);
  pass->setDepthWriteEnabled(false);
  pass->setCullingMode(Ogre::CULL_NONE);
  pass->setSceneBlending(Ogre::SBT_TRANSPARENT_ALPHA);
  return material;
}

}  // namespace rviz_mesh_plugin
