#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <OgrePrerequisites.h>
#include <OgreTexture.h>

#include "base/mesh_data.h"

namespace rviz_mesh_plugin {

/// One image on the graphics card with all its mipmaps, which are computed and uploaded in slices.
class MeshTexture
{
 public:
  /// Allocates. The image has at least one pixel, and sides that every graphics card takes (see
  /// GREATEST_TEXTURE_SIDE of conversion/material_conversion.h).
  explicit MeshTexture(const TextureImageConstPtr& image);
  ~MeshTexture();
  MeshTexture(const MeshTexture&) = delete;
  MeshTexture& operator=(const MeshTexture&) = delete;

  bool complete() const { return level_ == level_count_; }
  /// Uploads at most SLICE_BYTES (but at least two rows).
  void uploadSlice();

  const TextureImageConstPtr& image() const { return image_; }
  const Ogre::TexturePtr& get() const { return texture_; }
  std::size_t bytes() const { return bytes_; }

 private:
  TextureImageConstPtr image_;
  Ogre::TexturePtr texture_;
  std::size_t bytes_ = 0;
  int level_ = 0;  ///< being uploaded
  int level_count_ = 0;
  std::uint32_t width_;  ///< of the level
  std::uint32_t height_;
  std::uint32_t row_ = 0;           ///< the first that is not uploaded
  std::vector<Rgba8> pixels_;       ///< of the level; the first one is in the image
  std::vector<Rgba8> next_pixels_;  ///< of the next level, as far as they are computed
};

}  // namespace rviz_mesh_plugin
