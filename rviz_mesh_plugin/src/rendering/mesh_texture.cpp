#include "rendering/mesh_texture.h"

#include <algorithm>
#include <list>
#include <mutex>
#include <thread>

#include <OgreHardwarePixelBuffer.h>
#include <OgrePixelFormat.h>
#include <OgreResourceGroupManager.h>
#include <OgreTextureManager.h>

#include "base/texture_halving.h"
#include "rendering/mesh_buffers.h"
#include "rendering/ogre/ogre_compatibility.h"
#include "rendering/ogre/unique_name.h"

namespace rviz_mesh_plugin {
namespace {

using Textures = std::list<std::unique_ptr<MeshTexture>>;

/// Textures whose images went with other threads than the one that made them.
struct Left
{
  std::mutex mutex;
  Textures textures;
};

/// Never destroyed: threads may still use it while the process ends.
Left& left()
{
  static Left& instance = *new Left;
  return instance;
}

}  // namespace

std::shared_ptr<MeshTexture> MeshTexture::of(const TextureImage& image)
{
  destroyLeft();
  if (!image.uploaded) {
    const auto owner = std::make_shared<Textures>(1);  // so that nothing is allocated at the end
    const auto destroy = [owner, maker = std::this_thread::get_id()](MeshTexture* texture) {
      owner->front().reset(texture);
      if (std::this_thread::get_id() == maker) {
        owner->clear();
        return;
      }
      const std::lock_guard<std::mutex> lock(left().mutex);
      left().textures.splice(left().textures.end(), *owner);
    };
    image.uploaded = std::shared_ptr<MeshTexture>(new MeshTexture(image), destroy);
  }
  return std::static_pointer_cast<MeshTexture>(image.uploaded);
}

void MeshTexture::destroyLeft()
{
  Textures textures;  // destroyed without the lock
  const std::lock_guard<std::mutex> lock(left().mutex);
  textures.swap(left().textures);
}

MeshTexture::MeshTexture(const TextureImage& image)
    : translucent_(image.translucent), width_(image.width), height_(image.height)
{
  std::uint32_t width = width_;
  std::uint32_t height = height_;
  bytes_ = std::size_t{4} * width * height;
  for (level_count_ = 1; width > 1 || height > 1; ++level_count_) {
    width = halfOf(width);
    height = halfOf(height);
    bytes_ += std::size_t{4} * width * height;
  }
  pixels_.swap(image.pixels);
}

void MeshTexture::allocate()
{
  texture_ = Ogre::TextureManager::getSingleton().createManual(
      uniqueName("Texture"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME,
      Ogre::TEX_TYPE_2D, width_, height_, level_count_ - 1, Ogre::PF_BYTE_RGBA,
      Ogre::TU_STATIC_WRITE_ONLY);
}

bool MeshTexture::nextSliceIsLong() const
{
  return !isSet(texture_) && bytes_ > LONG_ALLOCATION;
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
  if (!isSet(texture_)) {
    allocate();
    return;
  }
  // An even number of rows, so that each slice is halved on its own.
  const std::size_t row_bytes = sizeof(Rgba8) * width_;
  const auto fitting = static_cast<std::uint32_t>(SLICE_BYTES / row_bytes / 2 * 2);
  const std::uint32_t count = std::min(std::max(fitting, 2u), height_ - row_);
  const Rgba8* rows = pixels_.data() + std::size_t{width_} * row_;
  // OGRE only reads what the box points to.
  const Ogre::PixelBox source(width_, count, 1, Ogre::PF_BYTE_RGBA, const_cast<Rgba8*>(rows));
  texture_->getBuffer(0, level_)->blitFromMemory(source,
                                                 Ogre::Box(0, row_, 0, width_, row_ + count, 1));
  if (level_ + 1 < level_count_) {
    appendHalved(rows, count, width_, height_, next_pixels_);
  }
  row_ += count;
  if (row_ == height_) {
    pixels_ = std::move(next_pixels_);
    next_pixels_ = std::vector<Rgba8>();
    width_ = halfOf(width_);
    height_ = halfOf(height_);
    row_ = 0;
    ++level_;
  }
  if (complete()) {
    pixels_ = std::vector<Rgba8>();
  }
}

}  // namespace rviz_mesh_plugin
