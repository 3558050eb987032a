#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <OgreHardwareVertexBuffer.h>

#include "coloring/color_source.h"
#include "level_of_detail/mesh_layout.h"
#include "level_of_detail/source_index.h"
#include "rendering/ogre_compatibility.h"

namespace rviz_mesh_plugin {

/// The colors of one layout on the graphics card, uploaded in slices. New colors go into a buffer
/// of their own, so that the old ones are seen until all are there.
class VertexColors
{
 public:
  explicit VertexColors(const LayoutOutlineConstPtr& layout);

  /// Colors all vertices anew.
  void start(const ColorSource& source);
  /// Asks the source of the colors again for these vertices (BY_FACE: faces) of the mesh.
  void update(const std::vector<std::uint32_t>& changed);
  void clear();

  /// Neither colors nor updates are left to upload.
  bool complete() const { return !isSet(coming_) && changed_.empty(); }
  /// All colors are there; updates may be left.
  bool usable() const { return !isSet(coming_); }
  void uploadSlice();

  /// Empty until all colors are there for the first time.
  const Ogre::HardwareVertexBufferSharedPtr& buffer() const { return buffer_; }
  std::size_t bytes() const;
  /// How often all colors were uploaded.
  std::size_t uploads() const { return uploads_; }

 private:
  void uploadComing();
  void uploadChanged();
  /// Colors the vertices [start, start + count).
  void write(Ogre::HardwareVertexBuffer* buffer, std::size_t start, std::size_t count);

  LayoutOutlineConstPtr layout_;
  ColorSource source_;
  Ogre::HardwareVertexBufferSharedPtr buffer_;
  Ogre::HardwareVertexBufferSharedPtr coming_;
  std::size_t done_ = 0;  ///< vertices of coming_
  std::vector<std::uint32_t> changed_;
  std::unique_ptr<SourceIndex> index_;  ///< from the first update on
  std::vector<Rgba8> scratch_;
  std::size_t uploads_ = 0;
};

}  // namespace rviz_mesh_plugin
