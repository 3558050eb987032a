#include "osmesa_harness/scene_counts.h"

#include <OgreGpuProgramManager.h>
#include <OgreHighLevelGpuProgramManager.h>
#include <OgreMaterialManager.h>
#include <OgreMeshManager.h>
#include <OgreMovableObject.h>
#include <OgreSceneNode.h>
#include <OgreTextureManager.h>

#include <set>
#include <tuple>

#include "ogre_compatibility.h"

namespace osmesa_harness {
namespace {

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
