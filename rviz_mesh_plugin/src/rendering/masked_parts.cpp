#include "rendering/masked_parts.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <iterator>
#include <system_error>

#include <OgreHardwareBufferManager.h>

namespace rviz_mesh_plugin {

void MaskedParts::add(MeshPartObject& part)
{
  parts_.resize(layout_->parts.size());
  sizes_.resize(layout_->parts.size());
  parts_[static_cast<std::size_t>(&part.part() - layout_->parts.data())] = &part;
}

void MaskedParts::hide(const HiddenFacesConstPtr& hidden)
{
  if (hidden == hidden_) {
    return;
  }
  hidden_ = hidden;
  coming_.clear();
  searching_.drop();
  if (!hidden || hidden == layout_->hidden || !layout_->faces || parts_.empty()) {
    take({});
    return;
  }
  try {
    searching_.start([layout = layout_, hidden](const Cancellation& cancellation) {
      return maskParts(*layout, hidden, cancellation.flag());
    });
  } catch (const std::system_error&) {
  }
}

bool MaskedParts::uploadSlice()
{
  if (auto found = searching_.take()) {
    searching_.drop();
    take(std::move(found->result).value_or(PartMasks()));
    return true;
  }
  if (coming_.empty()) {
    return false;
  }
  try {
    upload(coming_.front());
    coming_.pop_front();
  } catch (const std::exception&) {  // Ogre::Exception, std::bad_alloc
    coming_.clear();
  }
  return true;
}

void MaskedParts::take(PartMasks found)
{
  std::vector<bool> masked(parts_.size());
  for (const PartMask& mask : found.masks) {
    masked[mask.part] = true;
  }
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i] != nullptr && !masked[i]) {
      parts_[i]->unmask();
      bytes_ -= std::exchange(sizes_[i], 0);
    }
  }
  for (const std::size_t part : found.in_full) {
    if (parts_[part] != nullptr) {
      parts_[part]->drawInFull();
    }
  }
  coming_.assign(std::make_move_iterator(found.masks.begin()),
                 std::make_move_iterator(found.masks.end()));
}

void MaskedParts::upload(const PartMask& mask)
{
  MeshPartObject* part = parts_[mask.part];
  if (part == nullptr) {
    return;
  }
  Ogre::HardwareIndexBufferSharedPtr buffer;
  if (!mask.indices.empty()) {
    buffer = Ogre::HardwareBufferManager::getSingleton().createIndexBuffer(
        Ogre::HardwareIndexBuffer::IT_32BIT, mask.indices.size(),
        Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
    buffer->writeData(0, buffer->getSizeInBytes(), mask.indices.data(), true);
  }
  part->mask(buffer, mask.indices.size());
  const std::size_t size = mask.indices.size() * sizeof(std::uint32_t);
  bytes_ += size - std::exchange(sizes_[mask.part], size);
}

}  // namespace rviz_mesh_plugin
