#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "label_editing/label_history.h"
#include "label_editing/pending_edits.h"
#include "threads/background_task.h"

namespace rviz_mesh_plugin {

/// What becomes of an edit of labels that was asked for, at its turn.
struct EditPlan
{
  std::string reason;                            ///< why nothing does
  std::size_t faces = 0;                         ///< that have to be looked at
  std::function<std::vector<LabelEdit>()> make;  ///< for any thread; may throw
};

/// An edit of labels that was asked for.
struct EditCommand
{
  std::string what;  ///< as "deleting 'tree_1'"
  MeshId mesh;
  bool labels_known = false;  ///< of that, when it began: else nobody can tell what they were
  std::uint64_t order = 0;
  std::function<EditPlan()> begin;
  /// Of one that undoes or redoes, once it has begun, the step; else null.
  std::shared_ptr<LabelStep> step;
  bool undoes = false;
};

/// Edits that were asked for, until it is known what becomes of which label. Those of one mesh are
/// made in their order; what has to look at more than MANY_FACES is made ready on a thread, one
/// after the other. GUI thread only; nothing here waits.
class EditCommandQueue
{
 public:
  /// Who asks for them.
  struct User
  {
    /// Whether edits of a mesh can begin.
    std::function<bool(const MeshId& mesh)> is_shown;
    std::function<EditPlan(EditCommand& command)> begin;
    /// Takes what was made. Returns why it cannot be, else an empty string.
    std::function<std::string(const EditCommand& command, std::vector<LabelEdit> edits)> finish;
  };

  explicit EditCommandQueue(User user) : user_(std::move(user)) {}

  /// At once, or with its turn. Returns why it cannot be made, else an empty string.
  std::string perform(EditCommand command);

  /// To be called often. Returns why the last one could not be made, empty where it was; nothing
  /// where none was.
  std::optional<std::string> work();

  void giveUp();

  bool empty() const { return commands_.empty(); }
  std::size_t count() const { return commands_.size(); }
  /// There has to be one.
  const EditCommand& first() const { return commands_.front(); }
  /// Whether edits of a mesh have to wait.
  bool isBusy(const MeshId& mesh) const;
  /// Those that cannot begin, as their mesh is not shown.
  std::vector<const EditCommand*> held() const;

 private:
  std::string begin(EditCommand command);

  User user_;
  std::deque<EditCommand> commands_;  ///< the first one has begun where one is made ready
  BackgroundTask<std::vector<LabelEdit>> making_{"label faces"};
};

}  // namespace rviz_mesh_plugin
