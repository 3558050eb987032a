#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <OgreHardwareVertexBuffer.h>

#include "coloring/color_source.h"
#include "level_of_detail/mesh_layout.h"
#include "level_of_detail/source_index.h"
#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {

/// The colors of one layout on the graphics card, uploaded in slices. New colors go into a buffer
/// of their own, so that the old ones are seen until all are there. What is being uploaded is
/// finished, and the newest of those that came in the meantime is next: some are seen however fast
/// they come.
class VertexColors
{
 public:
  explicit VertexColors(const LayoutOutlineConstPtr& layout);

  /// Colors all vertices anew, now or as soon as those that are being uploaded are there.
  /// @param translucent whether a color may have an alpha below 255
  void start(const ColorSource& source, bool translucent);
  /// Goes on with another source, which differs for these vertices (BY_FACE: faces) of the mesh
  /// alone.
  void update(const ColorSource& source, const std::vector<std::uint32_t>& changed);
  void clear();

  /// Neither colors nor updates are left to upload.
  bool complete() const { return !isSet(coming_) && changed_.empty() && blocks_left_ == 0; }
  /// There are all colors of some source, or none to come.
  bool usable() const { return isSet(buffer_) || !isSet(coming_); }
  void uploadSlice();

  /// Empty until all colors are there for the first time.
  const Ogre::HardwareVertexBufferSharedPtr& buffer() const { return buffer_; }
  bool translucent() const { return translucent_; }
  std::size_t bytes() const;
  /// How often all colors were uploaded.
  std::size_t uploads() const { return uploads_; }

 private:
  /// Of all vertices.
  struct Request
  {
    ColorSource source;  ///< null: none
    bool translucent = false;
  };

  void begin(Request request);
  void uploadComing();
  void forgetChanged();
  void findBlocks();
  void uploadBlocks();
  /// Colors the vertices [start, start + count).
  void write(Ogre::HardwareVertexBuffer* buffer, std::size_t start, std::size_t count);

  LayoutOutlineConstPtr layout_;
  Request current_;  ///< what is uploaded, or has been
  Request next_;     ///< in its place, when it is
  bool translucent_ = false;
  Ogre::HardwareVertexBufferSharedPtr buffer_;
  Ogre::HardwareVertexBufferSharedPtr coming_;
  std::size_t done_ = 0;                ///< vertices of coming_
  std::vector<std::uint32_t> changed_;  ///< of the mesh, until it is known which blocks have them
  std::unique_ptr<SourceIndex> index_;  ///< from the first update on
  std::vector<bool> blocks_;            ///< of vertices, that are to be uploaded again
  std::size_t blocks_left_ = 0;
  std::size_t next_block_ = 0;
  std::vector<Rgba8> scratch_;
  std::size_t uploads_ = 0;
};

}  // namespace rviz_mesh_plugin
