#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/mesh_data.h"
#include "selection/face_selection.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

/// Finds faces on a thread of its own: one question after the other, answered in this order. GUI
/// thread only; nothing waits.
class SelectionQuery
{
 public:
  using Faces = FaceSelection::Faces;
  /// Owns what it uses. May throw; gives up soon after the flag is set.
  using Work = std::function<Faces(const std::atomic<bool>& cancel)>;

  struct Answer
  {
    MeshDataConstPtr mesh;
    bool adding = true;
    Faces faces;
    std::string failure;  ///< why there are none; else empty
  };

  SelectionQuery() = default;
  ~SelectionQuery();  ///< waits for nothing
  SelectionQuery(const SelectionQuery&) = delete;
  SelectionQuery& operator=(const SelectionQuery&) = delete;

  /// @throw std::system_error where no thread can be started, std::bad_alloc
  void ask(const MeshDataConstPtr& mesh, bool adding, Work work);

  /// Answers that have not been taken.
  std::size_t open() const { return open_; }

  std::optional<Answer> take();

  /// Forgets all questions; returns whether there were any.
  bool giveUp();

 private:
  struct Answers;
  std::shared_ptr<Answers> answers_;
  std::size_t open_ = 0;
  WorkThread thread_{"selection"};
};

}  // namespace rviz_mesh_plugin
