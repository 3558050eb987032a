#include "osmesa_harness/scene_counts.h"

#include <OgreGpuProgramManager.h>
#include <OgreHardwareBufferManager.h>
#include <OgreHighLevelGpuProgramManager.h>
#include <OgreMaterialManager.h>
#include <OgreMeshManager.h>
#include <OgreMovableObject.h>
#include <OgrePrerequisites.h>
#include <OgreRoot.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreTextureManager.h>

#include <set>
#include <tuple>

namespace osmesa_harness {
namespace {

// OGRE 1.9 (Ubuntu 20.04) and 1.12 differ here. Calls the function with each movable object that
// the scene manager has created (cameras excepted).
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

// OGRE lists its buffers, but tells nobody: a derived class may name the protected members.
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

using Objects = std::set<const Ogre::MovableObject*>;

// Counts the nodes below this one and collects what is attached to them: RViz has movable objects
// of its own (points, texts), which no scene manager knows.
std::size_t walk(Ogre::SceneNode* node, Objects* attached)
{
  for (unsigned short index = 0; index < node->numAttachedObjects(); ++index) {
    attached->insert(node->getAttachedObject(index));
  }
  std::size_t count = 0;
  for (unsigned short index = 0; index < node->numChildren(); ++index) {
    count += 1 + walk(static_cast<Ogre::SceneNode*>(node->getChild(index)), attached);
  }
  return count;
}

std::size_t resources(Ogre::ResourceManager& manager)
{
  std::size_t count = 0;
  for (auto found = manager.getResourceIterator(); found.hasMoreElements(); found.moveNext()) {
    ++count;
  }
  return count;
}

template <class Buffers>
std::size_t bytes(const Buffers& buffers)
{
  std::size_t sum = 0;
  for (const auto* buffer : buffers) {
    sum += buffer->getSizeInBytes();
  }
  return sum;
}

auto members(const SceneCounts& counts)
{
  return std::tie(counts.nodes, counts.movable_objects, counts.materials, counts.textures,
                  counts.meshes, counts.gpu_programs, counts.vertex_buffers, counts.index_buffers,
                  counts.vertex_buffer_bytes, counts.index_buffer_bytes);
}

}  // namespace

std::size_t SceneCounts::movable(const std::string& type) const
{
  const auto found = movable_objects.find(type);
  return found == movable_objects.end() ? 0 : found->second;
}

SceneCounts countScene(Ogre::SceneManager* scene_manager)
{
  SceneCounts counts;
  Objects objects;
  counts.nodes = walk(scene_manager->getRootSceneNode(), &objects);
  forEachCreatedObject(scene_manager,
                       [&objects](const Ogre::MovableObject* object) { objects.insert(object); });
  for (const Ogre::MovableObject* object : objects) {
    ++counts.movable_objects[object->getMovableType()];
  }
  counts.materials = resources(Ogre::MaterialManager::getSingleton());
  counts.textures = resources(Ogre::TextureManager::getSingleton());
  counts.meshes = resources(Ogre::MeshManager::getSingleton());
  counts.gpu_programs = resources(Ogre::GpuProgramManager::getSingleton()) +
                        resources(Ogre::HighLevelGpuProgramManager::getSingleton());
  const auto& buffers = Ogre::HardwareBufferManager::getSingleton();
  counts.vertex_buffers = BufferLists::vertexBuffers(buffers).size();
  counts.index_buffers = BufferLists::indexBuffers(buffers).size();
  counts.vertex_buffer_bytes = bytes(BufferLists::vertexBuffers(buffers));
  counts.index_buffer_bytes = bytes(BufferLists::indexBuffers(buffers));
  return counts;
}

bool operator==(const SceneCounts& a, const SceneCounts& b)
{
  return members(a) == members(b);
}

bool operator!=(const SceneCounts& a, const SceneCounts& b)
{
  return !(a == b);
}

std::ostream& operator<<(std::ostream& stream, const SceneCounts& counts)
{
  stream << "nodes " << counts.nodes << ", materials " << counts.materials << ", textures "
         << counts.textures << ", meshes " << counts.meshes << ", GPU programs "
         << counts.gpu_programs << ", vertex buffers " << counts.vertex_buffers << " ("
         << counts.vertex_buffer_bytes << " bytes), index buffers " << counts.index_buffers << " ("
         << counts.index_buffer_bytes << " bytes)";
  for (const auto& type : counts.movable_objects) {
    stream << ", " << type.first << " " << type.second;
  }
  return stream;
}

}  // namespace osmesa_harness
