#include "rendering/mesh_texture.h"

#include <algorithm>

#include <OgreHardwarePixelBuffer.h>
#include <OgrePixelFormat.h>
#include <OgreResourceGroupManager.h>
#include <OgreTextureManager.h>

#include "rendering/mesh_buffers.h"
#include "rendering/ogre_compatibility.h"
#include "rendering/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

std::uint32_t half(std::uint32_t side)
{
  return std::max(side / 2, 1u);
}

std::uint8_t mean(unsigned a, unsigned b, unsigned c, unsigned d)
{
  return static_cast<std::uint8_t>((a + b + c + d + 2) / 4);
}

Rgba8 mean(const Rgba8& a, const Rgba8& b, const Rgba8& c, const Rgba8& d)
{
  return {mean(a.red, b.red, c.red, d.red), mean(a.green, b.green, c.green, d.green),
          mean(a.blue, b.blue, c.blue, d.blue), mean(a.alpha, b.alpha, c.alpha, d.alpha)};
}

}  // namespace

MeshTexture::MeshTexture(const TextureImageConstPtr& image)
    : image_(image), width_(image->width), height_(image->height)
{
  std::uint32_t width = width_;
  std::uint32_t height = height_;
  for (; std::max(width, height) > MAX_TEXTURE_SIDE; width = half(width), height = half(height)) {
    --level_;
  }
  const std::uint32_t first_width = width;
  const std::uint32_t first_height = height;
  bytes_ = std::size_t{4} * width * height;
  for (level_count_ = 1; width > 1 || height > 1; ++level_count_) {
    width = half(width);
    height = half(height);
    bytes_ += std::size_t{4} * width * height;
  }
  texture_ = Ogre::TextureManager::getSingleton().createManual(
      uniqueName("Texture"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME,
      Ogre::TEX_TYPE_2D, first_width, first_height, level_count_ - 1, Ogre::PF_BYTE_RGBA,
      Ogre::TU_STATIC_WRITE_ONLY);
}

MeshTexture::~MeshTexture()
{
  removeResource(Ogre::TextureManager::getSingleton(), texture_);
}

void MeshTexture::uploadSlice()
{
  if (complete()) {
    return;
  }
  // An even number of rows, so that each slice is halved on its own.
  const std::size_t row_bytes = sizeof(Rgba8) * width_;
  const auto fitting = static_cast<std::uint32_t>(SLICE_BYTES / row_bytes / 2 * 2);
  const std::uint32_t count = std::min(std::max(fitting, 2u), height_ - row_);
  const Rgba8* rows =
      (pixels_.empty() ? image_->pixels : pixels_).data() + std::size_t{width_} * row_;
  if (level_ >= 0) {
    // OGRE only reads what the box points to.
    const Ogre::PixelBox source(width_, count, 1, Ogre::PF_BYTE_RGBA, const_cast<Rgba8*>(rows));
    texture_->getBuffer(0, level_)->blitFromMemory(source,
                                                   Ogre::Box(0, row_, 0, width_, row_ + count, 1));
  }
  halve(rows, count);
  row_ += count;
  if (row_ == height_) {
    pixels_ = std::move(next_pixels_);
    next_pixels_ = std::vector<Rgba8>();
    width_ = half(width_);
    height_ = half(height_);
    row_ = 0;
    ++level_;
  }
  if (complete()) {
    pixels_ = std::vector<Rgba8>();
  }
}

void MeshTexture::halve(const Rgba8* rows, std::uint32_t count)
{
  if (level_ + 1 == level_count_) {
    return;
  }
  const std::uint32_t width = half(width_);
  // A side of one pixel stays; of an odd side the last pixel is left out.
  const std::size_t right = width_ > 1 ? 1 : 0;
  const std::size_t below = height_ > 1 ? width_ : 0;
  const std::uint32_t row_count = height_ > 1 ? count / 2 : 1;
  next_pixels_.reserve(std::size_t{width} * half(height_));
  for (std::uint32_t row = 0; row < row_count; ++row) {
    const Rgba8* pixel = rows + std::size_t{2} * row * width_;
    for (std::uint32_t column = 0; column < width; ++column, pixel += 2) {
      next_pixels_.push_back(mean(pixel[0], pixel[right], pixel[below], pixel[below + right]));
    }
  }
}

}  // namespace rviz_mesh_plugin
