#pragma once

#include <cstddef>
#include <deque>
#include <utility>
#include <vector>

#include "base/hidden_faces.h"
#include "level_of_detail/mesh_layout.h"
#include "level_of_detail/part_masks.h"
#include "rendering/mesh_part_object.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// Takes hidden faces out of the parts of a mesh that are drawn, within a moment: what is left of
/// which ones is found on a thread, and uploaded in slices. Where there is no memory or thread for
/// that, they are drawn until the mesh has been laid out without them. GUI thread only.
class MaskedParts
{
 public:
  /// Parts of the layout are added, and outlive this.
  explicit MaskedParts(LayoutOutlineConstPtr layout) : layout_(std::move(layout)) {}
  void add(MeshPartObject& part);

  /// From now on these are, of the mesh of the layout (null: none); faces that the layout does not
  /// have are not drawn either way.
  void hide(const HiddenFacesConstPtr& hidden);

  /// Nothing is drawn any more of the faces that were hidden last.
  bool isComplete() const { return !searching_.isRunning() && coming_.empty(); }
  /// False where nothing is to be done now; perhaps the thread is at work.
  bool uploadSlice();

  std::size_t bytes() const { return bytes_; }

 private:
  void take(PartMasks found);
  void upload(const PartMask& mask);

  LayoutOutlineConstPtr layout_;
  std::vector<MeshPartObject*> parts_;  ///< by number; null where nothing is drawn
  HiddenFacesConstPtr hidden_;
  BackgroundTask<PartMasks> searching_{"hidden faces"};
  std::deque<PartMask> coming_;
  std::vector<std::size_t> sizes_;  ///< of the buffer of each part, in bytes
  std::size_t bytes_ = 0;           ///< of all
};

}  // namespace rviz_mesh_plugin
