#include "rendering/labels/label_vertices.h"

#include <algorithm>

#include <OgreHardwareBufferManager.h>

#include "base/vectors.h"
#include "rendering/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

constexpr unsigned short BINDING = 0;

/// Faces that are measured to tell how large those of the mesh are.
constexpr std::size_t SAMPLE = 1000;

/// The mean length of an edge.
float edgeOf(const MeshData& mesh)
{
  const std::size_t stride = std::max<std::size_t>(1, mesh.faceCount() / SAMPLE);
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t face = 0; face < mesh.faceCount(); face += stride) {
    const auto one = static_cast<std::uint32_t>(face);
    sum += distance(cornerOf(mesh, one, 0), cornerOf(mesh, one, 1));
    ++count;
  }
  return count == 0 ? 0.0f : static_cast<float>(sum / count);
}

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
  shared_ = LabelledMesh();
  shared_.mesh = mesh;
  if (mesh) {
    shared_.vertices = &data_;
    shared_.edge = edgeOf(*mesh);
    const Ogre::Vector3 lower(mesh->lower[0], mesh->lower[1], mesh->lower[2]);
    const Ogre::Vector3 upper(mesh->upper[0], mesh->upper[1], mesh->upper[2]);
    shared_.center = lower * 0.5f + upper * 0.5f;
    shared_.radius = upper.distance(shared_.center);
  }
}

std::size_t LabelVertices::upload(std::size_t limit)
{
  if (shared_.complete()) {
    return 0;
  }
  const MeshData& mesh = *shared_.mesh;
  if (!isSet(buffer_)) {
    buffer_ = Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
        sizeof(MeshVertex), mesh.vertexCount(), Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
    data_.vertexBufferBinding->setBinding(BINDING, buffer_);
    data_.vertexStart = 0;
    data_.vertexCount = mesh.vertexCount();
  }
  const std::size_t begin = shared_.vertices_uploaded;
  const std::size_t count =
      std::min(mesh.vertexCount() - begin, std::max<std::size_t>(1, limit / sizeof(MeshVertex)));
  buffer_->writeData(begin * sizeof(MeshVertex), count * sizeof(MeshVertex), &mesh.vertices[begin],
                     false);
  shared_.vertices_uploaded += count;
  return count * sizeof(MeshVertex);
}

std::size_t LabelVertices::gpuBytes() const
{
  return isSet(buffer_) ? buffer_->getSizeInBytes() : 0;
}

}  // namespace rviz_mesh_plugin
