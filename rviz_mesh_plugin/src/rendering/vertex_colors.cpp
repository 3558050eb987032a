#include "rendering/vertex_colors.h"

#include <algorithm>
#include <utility>

#include <OgreHardwareBufferManager.h>

#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

/// Colors are computed on the GUI thread: this many take a few milliseconds.
constexpr std::size_t SLICE_VERTICES = 1 << 18;

/// Where more than this part of the vertices changes, all are uploaded: that costs less then than
/// to find out where they lie.
constexpr std::size_t MANY_CHANGES = 16;

/// Vertices are uploaded again in blocks of so many; blocks are joined across as many as an upload
/// of its own costs.
constexpr std::size_t BLOCK = 4;
constexpr std::size_t JOINED_BLOCKS = 48;

/// Changed vertices (BY_FACE: faces), and uploads, of one slice.
constexpr std::size_t SLICE_CHANGES = 20000;
constexpr std::size_t SLICE_UPLOADS = 256;

}  // namespace

VertexColors::VertexColors(const LayoutOutlineConstPtr& layout) : layout_(layout) {}

void VertexColors::start(const ColorSource& source, bool translucent)
{
  Request request{source, translucent};
  if (isSet(coming_) && done_ > 0) {
    next_ = std::move(request);
    forgetChanged();  // all are asked for again
  } else {
    begin(std::move(request));
  }
}

void VertexColors::begin(Request request)
{
  current_ = std::move(request);
  forgetChanged();
  if (!isSet(coming_)) {
    coming_ = Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
        sizeof(Rgba8), layout_->sources.size(), Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY);
  }
  done_ = 0;
}

void VertexColors::update(const ColorSource& source, const std::vector<std::uint32_t>& changed)
{
  if (next_.source) {
    next_.source = source;  // it is asked for all
    return;
  }
  if (!current_.source) {
    return;
  }
  if (changed_.size() + changed.size() > layout_->sources.size() / MANY_CHANGES) {
    start(source, current_.translucent);
    return;
  }
  current_.source = source;
  changed_.insert(changed_.end(), changed.begin(), changed.end());
}

void VertexColors::forgetChanged()
{
  changed_.clear();
  blocks_.assign(blocks_.size(), false);
  blocks_left_ = next_block_ = 0;
}

void VertexColors::clear()
{
  current_ = next_ = Request();
  translucent_ = false;
  forgetChanged();
  buffer_ = Ogre::HardwareVertexBufferSharedPtr();
  coming_ = Ogre::HardwareVertexBufferSharedPtr();
  scratch_ = std::vector<Rgba8>();
}

std::size_t VertexColors::bytes() const
{
  return (isSet(buffer_) ? buffer_->getSizeInBytes() : 0) +
         (isSet(coming_) ? coming_->getSizeInBytes() : 0);
}

void VertexColors::uploadSlice()
{
  if (isSet(coming_)) {
    uploadComing();
  } else if (!changed_.empty()) {
    findBlocks();
  } else {
    uploadBlocks();
  }
}

void VertexColors::write(Ogre::HardwareVertexBuffer* buffer, std::size_t start, std::size_t count)
{
  scratch_.resize(std::max(scratch_.size(), count));
  current_.source(layout_->sources.data() + start, count, scratch_.data());
  buffer->writeData(start * sizeof(Rgba8), count * sizeof(Rgba8), scratch_.data(), false);
}

void VertexColors::uploadComing()
{
  const std::size_t count = std::min(SLICE_VERTICES, layout_->sources.size() - done_);
  try {
    write(coming_.get(), done_, count);
  } catch (...) {
    done_ = 0;
    if (next_.source) {
      begin(std::exchange(next_, Request()));
    }
    throw;
  }
  done_ += count;
  if (done_ == layout_->sources.size()) {
    buffer_ = coming_;
    translucent_ = current_.translucent;
    coming_ = Ogre::HardwareVertexBufferSharedPtr();
    scratch_ = std::vector<Rgba8>();
    ++uploads_;
    if (next_.source) {
      begin(std::exchange(next_, Request()));
    }
  }
}

void VertexColors::findBlocks()
{
  if (!index_) {
    const MeshData& mesh = *layout_->mesh;
    index_ = std::make_unique<SourceIndex>(
        layout_->sources, layout_->split == Split::BY_FACE ? mesh.faceCount() : mesh.vertexCount());
    blocks_.assign((layout_->sources.size() + BLOCK - 1) / BLOCK, false);
  }
  if (!index_->complete()) {
    index_->buildSlice();
    return;
  }
  const std::size_t rest = changed_.size() - std::min(SLICE_CHANGES, changed_.size());
  std::vector<std::uint32_t> vertices;
  for (std::size_t i = rest; i < changed_.size(); ++i) {
    index_->find(changed_[i], &vertices);
  }
  changed_.resize(rest);
  for (const std::uint32_t vertex : vertices) {
    blocks_left_ += blocks_[vertex / BLOCK] ? 0 : 1;
    blocks_[vertex / BLOCK] = true;
  }
  next_block_ = 0;
}

/// Those near to each other together.
void VertexColors::uploadBlocks()
{
  std::size_t vertices = 0;
  for (std::size_t uploads = 0;
       blocks_left_ > 0 && uploads < SLICE_UPLOADS && vertices < SLICE_VERTICES; ++uploads) {
    while (!blocks_[next_block_]) {
      ++next_block_;
    }
    const std::size_t first = next_block_;
    std::size_t end = first;
    for (; blocks_left_ > 0 && next_block_ < end + JOINED_BLOCKS && next_block_ < blocks_.size() &&
           (next_block_ - first) * BLOCK < SLICE_VERTICES;
         ++next_block_) {
      if (blocks_[next_block_]) {
        blocks_[next_block_] = false;
        --blocks_left_;
        end = next_block_ + 1;
      }
    }
    const std::size_t count = std::min(layout_->sources.size(), end * BLOCK) - first * BLOCK;
    write(buffer_.get(), first * BLOCK, count);
    vertices += count;
  }
}

}  // namespace rviz_mesh_plugin
