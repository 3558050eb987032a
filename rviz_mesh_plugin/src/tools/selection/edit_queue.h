#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "base/face_bits.h"
#include "base/hidden_faces.h"
#include "base/mesh_data.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {

class BrushMoves;

/// Edits of a selection, one after the other, in the order in which they were asked for: those that
/// come while faces are being looked for, on a thread, wait for their turn. Texts that are returned
/// tell the user what went otherwise than expected, and are empty where nothing did. GUI thread
/// only.
class EditQueue
{
 public:
  /// Of one mesh; none where nothing was found.
  struct Found
  {
    MeshDataConstPtr mesh;
    FaceBits faces;
    HiddenFacesConstPtr hidden{};  ///< where that was asked for, instead of faces
  };

  /// What is to be done with the selection.
  struct Edit
  {
    MeshDataConstPtr mesh;  ///< that has the selection then; null: the same as before, or unknown
    /// With its turn: begins to look for faces, or returns why not; may set all other members.
    /// Null: that has begun, or there is nothing to look for.
    std::function<std::string(Edit& edit)> begin;
    /// Set by begin: what it needs is not there yet, it is to be called again with the next
    /// advance().
    bool later = false;
    std::future<Found> found;  ///< invalid: there is nothing to look for
    std::function<std::string(Found found)> act;
    bool tells = true;                  ///< false: the text of the edit before still holds
    std::shared_ptr<BrushMoves> brush;  ///< of the brush, and not begun: may get more; else null
  };

  /// At once, or with its turn. What has been looked for is taken by advance(), however soon it is
  /// found.
  std::string perform(Edit edit);
  /// Makes edits that do not have to wait, for some time. Returns the text of the last one, which
  /// may be empty; none where none was made that tells anything.
  std::optional<std::string> advance();

  /// Begins on the thread. @param work owns what it uses, and gives up soon after the flag is set
  /// @throw std::system_error where no thread can be started, std::bad_alloc
  std::future<Found> ask(std::function<Found(const std::atomic<bool>& cancel)> work);

  bool empty() const { return edits_.empty(); }
  std::size_t size() const { return edits_.size(); }
  /// Null: none waits.
  Edit* last() { return edits_.empty() ? nullptr : &edits_.back(); }
  /// That has the selection once all of them are made, as far as they know; null: the same as
  /// before.
  MeshDataConstPtr comingMesh() const;

  /// Returns whether there were any.
  bool giveUp();

 private:
  std::deque<Edit> edits_;  ///< in their order; the first has to wait for its faces
  WorkThread thread_{"selection"};
};

}  // namespace rviz_mesh_plugin
