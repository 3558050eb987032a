#pragma once

/// Everything that differs between OGRE 1.9 (Ubuntu 20.04) and 1.12 (Debian 12). No other file asks
/// for the version or depends on it: 1.9 has its own shared pointers, which know neither bool nor
/// reset().

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreSharedPtr.h>
#if OGRE_VERSION < ((1 << 16) | (11 << 8) | 0)
#include <OgreVector3.h>
#else
#include <OgreVector.h>
#endif

namespace rviz_mesh_plugin {

template <class Pointer>
bool isSet(const Pointer& pointer)
{
  return pointer.get() != nullptr;
}

/// Removes a material, mesh, … from its manager by handle, the only way that both versions have for
/// all of them, and clears the pointer.
template <class Manager, class ResourcePointer>
void removeResource(Manager& manager, ResourcePointer& resource)
{
  if (isSet(resource)) {
    manager.remove(resource->getHandle());
    resource = ResourcePointer();
  }
}

/// Destroys a scene node and all nodes below it, whether or not it is part of the scene; objects
/// attached to them stay. (1.10.8 replaced 1.9's way of doing this through the parent.)
inline void destroySceneNode(Ogre::SceneNode* node)
{
  node->removeAndDestroyAllChildren();
  node->getCreator()->destroySceneNode(node);
}

}  // namespace rviz_mesh_plugin
