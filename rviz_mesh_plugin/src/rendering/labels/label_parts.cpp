#include "rendering/labels/label_parts.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>
#include <utility>

#include <OgreHardwareBufferManager.h>

#include "rendering/ogre/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

/// What the thread makes at a time: so little that it is not too much beside the mesh.
constexpr std::size_t PORTION_BYTES = std::size_t{16} << 20;

/// A buffer that is larger than what comes into it by more than this is made anew.
constexpr std::size_t MOST_SLACK = 2;

}  // namespace

struct LabelParts::Work
{
  std::vector<std::size_t> drawn;  ///< parts
  std::optional<OverlayFaces> faces;
};

void LabelParts::setFaces(MakeFaces faces)
{
  wanted_ = std::move(faces);
  if (!isMaking() && coming_.empty()) {
    start();
  }
}

bool LabelParts::isMade() const
{
  return portion_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

/// Only while the thread makes nothing.
void LabelParts::start()
{
  if (!work_) {
    work_ = std::make_shared<Work>();
    for (const auto& part : parts_) {
      work_->drawn.push_back(part.first);
    }
  }
  using Task = std::packaged_task<Portion(const Cancellation&)>;
  const auto task = std::make_shared<Task>(
      [work = work_, mesh = vertices_.mesh(), dropped = dropped_,
       wanted = std::exchange(wanted_, nullptr)](const Cancellation& cancellation) {
        Portion portion;
        if (*dropped) {
          return portion;  // and nobody takes it
        }
        if (!work->faces) {
          work->faces.emplace(mesh, OverlayLevels::of(mesh, cancellation.flag()), work->drawn);
        }
        portion.levels = work->faces->levels();
        if (wanted) {
          work->faces->setFaces(wanted());
        }
        portion.parts = work->faces->next(PORTION_BYTES, *dropped);
        portion.last = work->faces->isDone();
        return portion;
      });
  vertices_.thread().add([task](const Cancellation& cancellation) { (*task)(cancellation); });
  portion_ = task->get_future();
}

void LabelParts::take()
{
  if (!isMaking() || !isMade()) {
    return;
  }
  Portion portion = portion_.get();
  levels_ = portion.levels;
  coming_.assign(std::make_move_iterator(portion.parts.begin()),
                 std::make_move_iterator(portion.parts.end()));
  last_ = portion.last;
}

std::size_t LabelParts::upload(std::size_t& left)
{
  std::size_t uploaded = 0;
  if (coming_.empty()) {
    take();
    if (!isMaking() && (wanted_ || !last_)) {
      start();  // while these are uploaded
    }
  }
  while (!coming_.empty() && left > 0) {
    const std::size_t bytes = upload(coming_.front());
    coming_.pop_front();
    left -= std::min(left, std::max<std::size_t>(1, bytes));
    uploaded += bytes;
  }
  // Though others may have been set meanwhile: where that goes on, nothing would ever be drawn.
  drawable_ |= levels_ && coming_.empty() && last_;
  if (isComplete() && !changing_) {
    work_.reset();
  }
  return uploaded;
}

std::size_t LabelParts::upload(const PartFaces& faces)
{
  const std::size_t count = faces.indices.size();
  if (count == 0) {
    parts_.erase(faces.part);
    return 0;
  }
  const auto known = parts_.find(faces.part);
  Part part;  // only once it is complete it is drawn
  if (known != parts_.end()) {
    part.buffer = known->second.buffer;
  }
  const std::size_t room = isSet(part.buffer) ? part.buffer->getNumIndexes() : 0;
  if (room < count || room > MOST_SLACK * count) {
    part.buffer = Ogre::HardwareBufferManager::getSingleton().createIndexBuffer(
        Ogre::HardwareIndexBuffer::IT_32BIT, count, Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY);
  }
  const std::size_t bytes = count * sizeof(std::uint32_t);
  part.buffer->writeData(0, bytes, faces.indices.data(), bytes == part.buffer->getSizeInBytes());
  part.levels = faces.levels;
  part.whole = faces.whole;
  parts_[faces.part] = std::move(part);
  return bytes;
}

std::size_t LabelParts::gpuBytes() const
{
  std::size_t bytes = 0;
  for (const auto& part : parts_) {
    bytes += part.second.buffer->getSizeInBytes();
  }
  return bytes;
}

}  // namespace rviz_mesh_plugin
