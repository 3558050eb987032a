#include "rviz_mesh_plugin/mesh_buffers.h"

#include <algorithm>

#include <OgreHardwareBufferManager.h>

#include "rviz_mesh_plugin/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

constexpr unsigned short GEOMETRY_BINDING = 0;
constexpr unsigned short COLOR_BINDING = 1;
constexpr unsigned short TEXTURE_BINDING = 2;

}  // namespace

MeshBuffers::MeshBuffers(const MeshLayoutConstPtr& layout) : layout_(layout)
{
  vertices_.vertexStart = 0;
  vertices_.vertexCount = layout->vertices.size();
  auto* declaration = vertices_.vertexDeclaration;
  declaration->addElement(GEOMETRY_BINDING, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION);
  declaration->addElement(GEOMETRY_BINDING, 3 * sizeof(float), Ogre::VET_FLOAT3, Ogre::VES_NORMAL);
  addStream({layout->vertices.data(), layout->vertices.size() * sizeof(MeshVertex),
             sizeof(MeshVertex), GEOMETRY_BINDING});
  if (!layout->texture_coordinates.empty()) {
    declaration->addElement(TEXTURE_BINDING, 0, Ogre::VET_FLOAT2, Ogre::VES_TEXTURE_COORDINATES, 0);
    addStream({layout->texture_coordinates.data(),
               layout->texture_coordinates.size() * 2 * sizeof(float), 2 * sizeof(float),
               TEXTURE_BINDING});
  }
  addStream({layout->indices.data(), layout->indices.size() * sizeof(std::uint32_t),
             sizeof(std::uint32_t), 0});
}

void MeshBuffers::addStream(const Stream& stream)
{
  streams_.push_back(stream);
  bytes_ += stream.size;
}

void MeshBuffers::allocate(Stream* stream)
{
  auto& manager = Ogre::HardwareBufferManager::getSingleton();
  const std::size_t count = stream->size / stream->element_size;
  if (stream == &streams_.back()) {
    indices_ = manager.createIndexBuffer(Ogre::HardwareIndexBuffer::IT_32BIT, count,
                                         Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
    stream->buffer = indices_.get();
    return;
  }
  const auto buffer = manager.createVertexBuffer(stream->element_size, count,
                                                 Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
  vertices_.vertexBufferBinding->setBinding(stream->binding, buffer);
  stream->buffer = buffer.get();
}

bool MeshBuffers::verticesComplete() const
{
  return next_ + 1 >= streams_.size();
}

std::size_t MeshBuffers::uploadedIndices() const
{
  return streams_.back().done / sizeof(std::uint32_t);
}

void MeshBuffers::uploadSlice()
{
  if (complete()) {
    return;
  }
  Stream& stream = streams_[next_];
  if (!stream.buffer) {
    allocate(&stream);
    return;
  }
  const std::size_t size = std::min(SLICE_BYTES, stream.size - stream.done);
  stream.buffer->writeData(stream.done, size,
                           static_cast<const unsigned char*>(stream.data) + stream.done, false);
  stream.done += size;
  uploaded_bytes_ += size;
  if (stream.done == stream.size) {
    ++next_;
  }
}

void MeshBuffers::bindColors(const Ogre::HardwareVertexBufferSharedPtr& colors)
{
  auto* declaration = vertices_.vertexDeclaration;
  auto* binding = vertices_.vertexBufferBinding;
  if (binding->isBufferBound(COLOR_BINDING)) {
    declaration->removeElement(Ogre::VES_DIFFUSE);
    binding->unsetBinding(COLOR_BINDING);
  }
  if (isSet(colors)) {
    declaration->addElement(COLOR_BINDING, 0, Ogre::VET_COLOUR_ABGR, Ogre::VES_DIFFUSE);
    binding->setBinding(COLOR_BINDING, colors);
  }
}

}  // namespace rviz_mesh_plugin
