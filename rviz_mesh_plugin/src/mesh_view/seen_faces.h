#pragma once

#include <memory>
#include <optional>

#include "base/hidden_faces.h"
#include "base/mesh_data.h"
#include "base/section.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// Whether there is anything to be seen of a mesh that is cut, or of which faces are hidden. That
/// is looked for on a thread, until a face is found. GUI thread only.
class SeenFaces
{
 public:
  /// To be called often. False: no face is left. True also as long as that is not known.
  /// @param mesh null: there is none
  /// @param hidden null: none is
  bool any(const MeshDataConstPtr& mesh, const Section& section, const HiddenFacesConstPtr& hidden);

  /// Whether the last answer was known.
  bool isKnown() const { return !task_.isRunning(); }

 private:
  std::weak_ptr<const MeshData> mesh_;  ///< that the answer is of
  Section section_;
  HiddenFacesConstPtr hidden_;
  bool any_ = true;
  BackgroundTask<bool> task_{"seen faces"};
};

}  // namespace rviz_mesh_plugin
