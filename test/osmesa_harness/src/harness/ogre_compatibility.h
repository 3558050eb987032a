// Everything in which OGRE 1.9 (Ubuntu 20.04) and 1.12 differ, as far as the harness meets it.
#pragma once

#include <OgreHardwareBufferManager.h>
#include <OgreMovableObject.h>
#include <OgrePrerequisites.h>
#include <OgreRoot.h>
#include <OgreSceneManager.h>

namespace osmesa_harness {

/// Calls @a function with each movable object that the scene manager has created (cameras
/// excepted).
template <class Function>
void forEachCreatedObject(Ogre::SceneManager* scene_manager, Function function)
{
#if OGRE_VERSION >= ((1 << 16) | (12 << 8))
  for (const auto& factory : Ogre::Root::getSingleton().getMovableObjectFactories()) {
    for (const auto& object : scene_manager->getMovableObjects(factory.first)) {
      function(object.second);
    }
  }
#else
  for (auto types = Ogre::Root::getSingleton().getMovableObjectFactoryIterator();
       types.hasMoreElements(); types.moveNext()) {
    for (auto objects = scene_manager->getMovableObjectIterator(types.peekNextKey());
         objects.hasMoreElements(); objects.moveNext()) {
      function(objects.peekNextValue());
    }
  }
#endif
}

/// OGRE lists its buffers, but tells nobody: a derived class may name the protected members.
class BufferLists : public Ogre::HardwareBufferManagerBase
{
 public:
  static const VertexBufferList& vertexBuffers(const Ogre::HardwareBufferManagerBase& manager)
  {
    return manager.*(&BufferLists::mVertexBuffers);
  }
  static const IndexBufferList& indexBuffers(const Ogre::HardwareBufferManagerBase& manager)
  {
    return manager.*(&BufferLists::mIndexBuffers);
  }
};

}  // namespace osmesa_harness
