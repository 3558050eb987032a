#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <OgreHardwareIndexBuffer.h>
#include <OgreHardwareVertexBuffer.h>
#include <OgreVertexIndexData.h>

#include "level_of_detail/mesh_layout.h"

namespace rviz_mesh_plugin {

/// No slice of an upload has more bytes than this.
constexpr std::size_t SLICE_BYTES = std::size_t{4} << 20;

/// To allocate more bytes than this takes 5 ms and more: software drivers fill them with zeros.
constexpr std::size_t LONG_ALLOCATION = std::size_t{16} << 20;

/// An index buffer ends where the next range of a part would give it more indices than these: 32
/// MB.
constexpr std::size_t INDICES_PER_BUFFER = std::size_t{8} << 20;

/// The vertices, texture coordinates and faces of one layout on the graphics card, uploaded in
/// slices: first the vertices, then the faces from the coarsest level of detail to the full one.
/// The layout is let go then.
class MeshBuffers
{
 public:
  /// The layout has at least one vertex and one face.
  explicit MeshBuffers(const MeshLayoutConstPtr& layout,
                       std::size_t indices_per_buffer = INDICES_PER_BUFFER);

  /// Nothing is left to upload.
  bool complete() const { return next_ == streams_.size(); }
  bool verticesComplete() const;
  /// All indices of the mesh before this one are uploaded.
  std::size_t uploadedIndices() const;

  /// Allocates one buffer (software drivers fill it with zeros, which takes its time) or uploads at
  /// most SLICE_BYTES of it, if anything is left.
  void uploadSlice();
  /// The next slice allocates a buffer so large that nothing else should be done with it.
  bool nextSliceIsLong() const;

  std::size_t bytes() const { return bytes_; }
  std::size_t uploadedBytes() const { return uploaded_bytes_; }

  Ogre::VertexData* vertices() { return &vertices_; }

  /// The indices of the layout from @a begin on, until the next one begins. There are several, so
  /// that none takes long to allocate; no range of a part lies in two.
  struct IndexBuffer
  {
    std::size_t begin = 0;
    Ogre::HardwareIndexBufferSharedPtr buffer;
  };
  const IndexBuffer& indexBuffer(std::size_t index) const;

  /// Draws with these colors, one per vertex, from now on; without any if the pointer is empty.
  void bindColors(const Ogre::HardwareVertexBufferSharedPtr& colors);

 private:
  struct Stream
  {
    const void* data;
    std::size_t stride;  ///< from one element to the next, in bytes
    std::size_t size;    ///< of all elements, in bytes
    std::size_t element_size;
    std::size_t binding;  ///< of vertices; of indices: which of the index buffers
    std::size_t done = 0;
    Ogre::HardwareBuffer* buffer = nullptr;
  };

  void allocate(Stream* stream);
  void write(Stream* stream, std::size_t size);

  MeshLayoutConstPtr layout_;  ///< until all is uploaded
  Ogre::VertexData vertices_;
  std::vector<IndexBuffer> indices_;
  std::vector<Stream> streams_;  ///< the last ones are those of the indices
  std::size_t next_ = 0;
  std::vector<unsigned char> scratch_;
  std::size_t bytes_ = 0;
  std::size_t uploaded_bytes_ = 0;
};

}  // namespace rviz_mesh_plugin
