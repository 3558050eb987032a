#include "rviz_mesh_plugin/mesh_object.h"

#include <algorithm>

#include <OgreEntity.h>
#include <OgreHardwareBufferManager.h>
#include <OgreMeshManager.h>
#include <OgreResourceGroupManager.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreSubMesh.h>

#include "rviz_mesh_plugin/ogre_compatibility.h"
#include "rviz_mesh_plugin/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

constexpr unsigned short GEOMETRY_BINDING = 0;
constexpr unsigned short COLOR_BINDING = 1;

Ogre::HardwareVertexBufferSharedPtr createVertexBuffer(std::size_t vertex_size, std::size_t count,
                                                       Ogre::HardwareBuffer::Usage usage,
                                                       const void* data)
{
  auto buffer =
      Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(vertex_size, count, usage);
  buffer->writeData(0, buffer->getSizeInBytes(), data, true);
  return buffer;
}

}  // namespace

MeshObject::MeshObject(Ogre::SceneManager* scene_manager,
                       Ogre::RenderOperation::OperationType operation)
    : scene_manager_(scene_manager),
      mesh_(Ogre::MeshManager::getSingleton().createManual(
          uniqueName("Mesh"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME))
{
  mesh_->setAutoBuildEdgeLists(false);
  mesh_->sharedVertexData = OGRE_NEW Ogre::VertexData();
  Ogre::SubMesh* part = mesh_->createSubMesh();
  part->useSharedVertices = true;
  part->operationType = operation;
}

MeshObject::~MeshObject()
{
  if (entity_) {
    attachTo(nullptr);
    scene_manager_->destroyEntity(entity_);
  }
  removeResource(Ogre::MeshManager::getSingleton(), mesh_);
}

void MeshObject::setVertices(const void* data, std::size_t count, bool has_normals)
{
  Ogre::VertexData* vertices = mesh_->sharedVertexData;
  vertices->vertexStart = 0;
  vertices->vertexCount = count;
  auto* declaration = vertices->vertexDeclaration;
  declaration->removeAllElements();
  std::size_t size =
      declaration->addElement(GEOMETRY_BINDING, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION).getSize();
  if (has_normals) {
    size += declaration->addElement(GEOMETRY_BINDING, size, Ogre::VET_FLOAT3, Ogre::VES_NORMAL)
                .getSize();
  }
  vertices->vertexBufferBinding->setBinding(
      GEOMETRY_BINDING,
      createVertexBuffer(size, count, Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY, data));
}

void MeshObject::setIndices(const std::vector<std::uint32_t>& indices)
{
  auto buffer = Ogre::HardwareBufferManager::getSingleton().createIndexBuffer(
      Ogre::HardwareIndexBuffer::IT_32BIT, indices.size(),
      Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
  buffer->writeData(0, buffer->getSizeInBytes(), indices.data(), true);
  Ogre::IndexData* data = mesh_->getSubMesh(0)->indexData;
  data->indexStart = 0;
  data->indexCount = indices.size();
  data->indexBuffer = buffer;
}

void MeshObject::finish(const Ogre::AxisAlignedBox& bounds, const Ogre::MaterialPtr& material)
{
  mesh_->_setBounds(bounds, false);
  // About the origin of the node, as OGRE uses it.
  mesh_->_setBoundingSphereRadius(
      std::max(bounds.getMinimum().length(), bounds.getMaximum().length()));
  mesh_->load();
  entity_ = scene_manager_->createEntity(uniqueName("Entity"), mesh_);
  entity_->setMaterial(material);
  entity_->setCastShadows(false);
}

void MeshObject::attachTo(Ogre::SceneNode* node)
{
  if (entity_->getParentSceneNode() == node) {
    return;
  }
  entity_->detachFromParent();
  if (node) {
    node->attachObject(entity_);
  }
}

void MeshObject::setColors(const std::vector<Rgba8>& colors)
{
  Ogre::VertexData* vertices = mesh_->sharedVertexData;
  if (isSet(color_buffer_) && color_buffer_->getNumVertices() == colors.size()) {
    color_buffer_->writeData(0, color_buffer_->getSizeInBytes(), colors.data(), true);
    return;
  }
  clearColors();
  color_buffer_ =
      createVertexBuffer(sizeof(Rgba8), colors.size(),
                         Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY_DISCARDABLE, colors.data());
  vertices->vertexDeclaration->addElement(COLOR_BINDING, 0, Ogre::VET_COLOUR_ABGR,
                                          Ogre::VES_DIFFUSE);
  vertices->vertexBufferBinding->setBinding(COLOR_BINDING, color_buffer_);
}

void MeshObject::clearColors()
{
  if (!isSet(color_buffer_)) {
    return;
  }
  mesh_->sharedVertexData->vertexDeclaration->removeElement(Ogre::VES_DIFFUSE);
  mesh_->sharedVertexData->vertexBufferBinding->unsetBinding(COLOR_BINDING);
  color_buffer_ = Ogre::HardwareVertexBufferSharedPtr();
}

bool MeshObject::hasColors() const
{
  return isSet(color_buffer_);
}

}  // namespace rviz_mesh_plugin
