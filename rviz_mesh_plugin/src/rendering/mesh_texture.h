#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <OgrePrerequisites.h>
#include <OgreTexture.h>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// One image on the graphics card with all its mipmaps, which are computed and uploaded in slices.
/// Takes the pixels from the image and frees them as they are uploaded: from then on it is the
/// image, which owns it. Where an image goes with another thread, which has copied a list of them
/// for a moment, its texture waits for the GUI thread.
class MeshTexture
{
 public:
  /// That of an image. The image has at least one pixel, and sides that every graphics card takes
  /// (see GREATEST_TEXTURE_SIDE of conversion/material_conversion.h). GUI thread only.
  static std::shared_ptr<MeshTexture> of(const TextureImage& image);

  /// Destroys those that wait for it. GUI thread only.
  static void destroyLeft();

  ~MeshTexture();
  MeshTexture(const MeshTexture&) = delete;
  MeshTexture& operator=(const MeshTexture&) = delete;

  bool complete() const { return level_ == level_count_; }
  /// Allocates, or uploads at most SLICE_BYTES (but at least two rows).
  void uploadSlice();
  /// The next slice allocates so much that nothing else should be done with it.
  bool nextSliceIsLong() const;

  bool translucent() const { return translucent_; }
  /// Not set before the first slice.
  const Ogre::TexturePtr& get() const { return texture_; }
  std::size_t bytes() const { return bytes_; }

 private:
  explicit MeshTexture(const TextureImage& image);
  void allocate();

  Ogre::TexturePtr texture_;
  bool translucent_;
  std::size_t bytes_ = 0;
  int level_ = 0;  ///< being uploaded
  int level_count_ = 0;
  std::uint32_t width_;  ///< of the level
  std::uint32_t height_;
  std::uint32_t row_ = 0;           ///< the first that is not uploaded
  std::vector<Rgba8> pixels_;       ///< of the level
  std::vector<Rgba8> next_pixels_;  ///< of the next level, as far as they are computed
};

}  // namespace rviz_mesh_plugin
