#include "rendering/labels/label_vertices.h"

#include <algorithm>

#include <OgreHardwareBufferManager.h>

#include "level_of_detail/mesh_region.h"
#include "rendering/ogre/finite_bounds.h"
#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

constexpr unsigned short BINDING = 0;

}  // namespace

LabelVertices::LabelVertices()
{
  data_.vertexDeclaration->addElement(BINDING, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION);
  data_.vertexDeclaration->addElement(BINDING, 3 * sizeof(float), Ogre::VET_FLOAT3,
                                      Ogre::VES_NORMAL);
}

void LabelVertices::setMesh(const MeshDataConstPtr& mesh)
{
  data_.vertexBufferBinding->unsetAllBindings();
  data_.vertexCount = 0;
  buffer_ = Ogre::HardwareVertexBufferSharedPtr();
  uploaded_ = 0;
  thread_.cancel();
  mesh_ = mesh;
  if (mesh) {
    box_ = finiteBounds(*mesh);
    edge_ = typicalEdge(*mesh);
  }
}

std::size_t LabelVertices::upload(std::size_t limit)
{
  if (complete()) {
    return 0;
  }
  if (!isSet(buffer_)) {
    buffer_ = Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
        sizeof(MeshVertex), mesh_->vertexCount(), Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
    data_.vertexBufferBinding->setBinding(BINDING, buffer_);
    data_.vertexStart = 0;
    data_.vertexCount = mesh_->vertexCount();
  }
  const std::size_t count = std::min(mesh_->vertexCount() - uploaded_,
                                     std::max<std::size_t>(1, limit / sizeof(MeshVertex)));
  buffer_->writeData(uploaded_ * sizeof(MeshVertex), count * sizeof(MeshVertex),
                     &mesh_->vertices[uploaded_], false);
  uploaded_ += count;
  return count * sizeof(MeshVertex);
}

std::size_t LabelVertices::gpuBytes() const
{
  return isSet(buffer_) ? buffer_->getSizeInBytes() : 0;
}

}  // namespace rviz_mesh_plugin
