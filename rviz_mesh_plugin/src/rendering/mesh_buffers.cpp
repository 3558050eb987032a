#include "rendering/mesh_buffers.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>

#include <OgreHardwareBufferManager.h>

#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

// Buffers of their own, so that none takes long to allocate.
constexpr unsigned short POSITION_BINDING = 0;
constexpr unsigned short NORMAL_BINDING = 1;
constexpr unsigned short COLOR_BINDING = 2;
constexpr unsigned short TEXTURE_BINDING = 3;

/// Where the index buffers of a layout begin, and the end.
std::vector<std::size_t> cutIndices(const MeshLayout& layout, std::size_t indices_per_buffer)
{
  std::vector<IndexRange> ranges;
  for (const MeshPart& part : layout.parts) {
    ranges.insert(ranges.end(), part.levels.begin(), part.levels.end());
  }
  std::sort(ranges.begin(), ranges.end(),
            [](const IndexRange& a, const IndexRange& b) { return a.start < b.start; });
  std::vector<std::size_t> cuts{0};
  std::size_t behind = 0;  // all ranges so far
  for (const IndexRange& range : ranges) {
    const std::size_t end = range.end();
    if (range.start >= behind && range.start > cuts.back() &&
        end - cuts.back() > indices_per_buffer) {
      cuts.push_back(range.start);
    }
    behind = std::max(behind, end);
  }
  cuts.push_back(layout.indices.size());
  return cuts;
}

}  // namespace

MeshBuffers::MeshBuffers(const MeshLayoutConstPtr& layout, std::size_t indices_per_buffer)
    : layout_(layout)
{
  const auto add = [this](const auto* data, std::size_t stride, std::size_t count,
                          std::size_t binding) {
    streams_.push_back({data, stride, count * sizeof(*data), sizeof(*data), binding});
    bytes_ += streams_.back().size;
  };
  const std::size_t count = layout->vertices.size();
  vertices_.vertexStart = 0;
  vertices_.vertexCount = count;
  auto* declaration = vertices_.vertexDeclaration;
  declaration->addElement(POSITION_BINDING, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION);
  declaration->addElement(NORMAL_BINDING, 0, Ogre::VET_FLOAT3, Ogre::VES_NORMAL);
  add(&layout->vertices.front().position, sizeof(MeshVertex), count, POSITION_BINDING);
  add(&layout->vertices.front().normal, sizeof(MeshVertex), count, NORMAL_BINDING);
  if (!layout->texture_coordinates.empty()) {
    declaration->addElement(TEXTURE_BINDING, 0, Ogre::VET_FLOAT2, Ogre::VES_TEXTURE_COORDINATES, 0);
    add(layout->texture_coordinates.data(), sizeof(layout->texture_coordinates.front()), count,
        TEXTURE_BINDING);
  }
  const std::vector<std::size_t> cuts = cutIndices(*layout, indices_per_buffer);
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    add(layout->indices.data() + cuts[i - 1], sizeof(std::uint32_t), cuts[i] - cuts[i - 1],
        indices_.size());
    indices_.push_back({cuts[i - 1], {}});
  }
}

const MeshBuffers::IndexBuffer& MeshBuffers::indexBuffer(std::size_t index) const
{
  const auto behind = std::upper_bound(
      indices_.begin(), indices_.end(), index,
      [](std::size_t value, const IndexBuffer& buffer) { return value < buffer.begin; });
  return *std::prev(behind);
}

void MeshBuffers::allocate(Stream* stream)
{
  auto& manager = Ogre::HardwareBufferManager::getSingleton();
  const std::size_t count = stream->size / stream->element_size;
  if (verticesComplete()) {
    auto& indices = indices_[stream->binding].buffer;
    indices = manager.createIndexBuffer(Ogre::HardwareIndexBuffer::IT_32BIT, count,
                                        Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
    stream->buffer = indices.get();
    return;
  }
  const auto buffer = manager.createVertexBuffer(stream->element_size, count,
                                                 Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
  vertices_.vertexBufferBinding->setBinding(static_cast<unsigned short>(stream->binding), buffer);
  stream->buffer = buffer.get();
}

bool MeshBuffers::verticesComplete() const
{
  return next_ + indices_.size() >= streams_.size();
}

std::size_t MeshBuffers::uploadedIndices() const
{
  std::size_t bytes = 0;
  for (std::size_t i = streams_.size() - indices_.size(); i < streams_.size(); ++i) {
    bytes += streams_[i].done;
  }
  return bytes / sizeof(std::uint32_t);
}

bool MeshBuffers::nextSliceIsLong() const
{
  return !complete() && !streams_[next_].buffer && streams_[next_].size > LONG_ALLOCATION;
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
  const std::size_t slice = SLICE_BYTES / stream.element_size * stream.element_size;
  const std::size_t size = std::min(slice, stream.size - stream.done);
  write(&stream, size);
  stream.done += size;
  uploaded_bytes_ += size;
  if (stream.done == stream.size) {
    ++next_;
  }
  if (complete()) {
    layout_ = nullptr;
    scratch_ = std::vector<unsigned char>();
  }
}

/// The next bytes of a stream.
void MeshBuffers::write(Stream* stream, std::size_t size)
{
  const auto* from = static_cast<const unsigned char*>(stream->data) +
                     stream->done / stream->element_size * stream->stride;
  if (stream->stride == stream->element_size) {
    stream->buffer->writeData(stream->done, size, from, false);
    return;
  }
  scratch_.resize(std::max(scratch_.size(), size));
  for (std::size_t i = 0; i < size; i += stream->element_size, from += stream->stride) {
    std::memcpy(&scratch_[i], from, stream->element_size);
  }
  stream->buffer->writeData(stream->done, size, scratch_.data(), false);
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
