#include "rendering/vertex_colors.h"

#include <algorithm>
#include <utility>

#include <OgreHardwareBufferManager.h>

#include "rendering/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

/// Colors are computed on the GUI thread: this many take a few milliseconds.
constexpr std::size_t SLICE_VERTICES = 1 << 18;

/// Where more than this part of the vertices changes, all are uploaded.
constexpr std::size_t MANY_CHANGES = 4;

/// Changed vertices this near to each other are uploaded together.
constexpr std::uint32_t JOINED_GAP = 16;

/// Changed vertices (BY_FACE: faces) of one slice.
constexpr std::size_t SLICE_CHANGES = 20000;

}  // namespace

VertexColors::VertexColors(const LayoutOutlineConstPtr& layout) : layout_(layout) {}

void VertexColors::start(const ColorSource& source, bool translucent)
{
  Request request{source, translucent};
  if (isSet(coming_) && done_ > 0) {
    next_ = std::move(request);
    changed_.clear();  // all are asked for again
  } else {
    begin(std::move(request));
  }
}

void VertexColors::begin(Request request)
{
  current_ = std::move(request);
  changed_.clear();
  if (!isSet(coming_)) {
    coming_ = Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
        sizeof(Rgba8), layout_->sources.size(), Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY);
  }
  done_ = 0;
}

void VertexColors::update(const std::vector<std::uint32_t>& changed)
{
  if (!current_.source || changed.empty() || next_.source) {
    return;  // of the next, all are asked for
  }
  if (changed_.size() + changed.size() > layout_->sources.size() / MANY_CHANGES) {
    start(ColorSource(current_.source), current_.translucent);
    return;
  }
  changed_.insert(changed_.end(), changed.begin(), changed.end());
}

void VertexColors::clear()
{
  current_ = next_ = Request();
  translucent_ = false;
  changed_.clear();
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
    uploadChanged();
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

void VertexColors::uploadChanged()
{
  if (!index_) {
    const MeshData& mesh = *layout_->mesh;
    index_ = std::make_unique<SourceIndex>(
        layout_->sources, layout_->split == Split::BY_FACE ? mesh.faceCount() : mesh.vertexCount());
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
  std::sort(vertices.begin(), vertices.end());
  for (std::size_t i = 0; i < vertices.size();) {
    const std::uint32_t first = vertices[i];
    std::uint32_t last = first;
    for (; i < vertices.size() && vertices[i] - last <= JOINED_GAP; ++i) {
      last = vertices[i];
    }
    write(buffer_.get(), first, last - first + 1);
  }
}

}  // namespace rviz_mesh_plugin
