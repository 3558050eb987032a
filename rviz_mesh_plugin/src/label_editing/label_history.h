#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "label_editing/pending_edits.h"
#include "labels/face_parents.h"

namespace rviz_mesh_plugin {

/// What a label is, or was.
struct LabelState
{
  LabelFacesConstPtr faces;    ///< not null; none: there is no such label
  std::optional<Rgba8> color;  ///< of its own
};

struct LabelChange
{
  std::string label;
  LabelState before;
  LabelState after;
};

/// What a user did to labels at once.
struct LabelStep
{
  std::uint64_t order = 0;  ///< see step_history.h
  MeshId mesh;
  std::string what;  ///< as "deleting 'tree_1'"
  std::vector<LabelChange> changes;

  /// Of the faces, as if nobody else had them.
  std::size_t bytes() const;
};

/// What these edits, of one mesh, do to labels: there has to be one.
/// @param state what a label is before them
LabelStep stepOf(const std::string& what, std::uint64_t order, const std::vector<LabelEdit>& edits,
                 const std::function<LabelState(const std::string& label)>& state);

/// What a label is now, and how it is stored, which is another thing while an edit is on its way.
struct LabelNow
{
  LabelState state;
  LabelFacesConstPtr stored;
};

/// The edits by which labels become again what they were before a step (or after it, where it is
/// redone), for any thread. None of them is made where a label is not as the step has left it:
/// somebody else has changed it since, and that would be lost.
/// @param now of each label of the step, in its order
/// @param parents of the mesh, or null: labels are stored as whole faces of these
/// @throw std::runtime_error that says which label, and what becomes of the step
std::vector<LabelEdit> editsBack(const LabelStep& step, bool undo, const std::vector<LabelNow>& now,
                                 const FaceParentsConstPtr& parents);

/// The steps that can be undone and redone, of the meshes that were edited last. Where they are too
/// many, the oldest are forgotten.
class LabelHistory
{
 public:
  static constexpr std::size_t BYTES = std::size_t{256} << 20;
  static constexpr std::size_t MESHES = 8;

  explicit LabelHistory(std::size_t bytes = BYTES) : bytes_(bytes) {}

  /// One that was made, or made again.
  void addDone(LabelStep step) { put(done_, std::move(step)); }
  void addUndone(LabelStep step) { put(undone_, std::move(step)); }

  /// Of the newest step of a mesh, and of the one undone last; 0: there is none.
  std::uint64_t undoOrder(const MeshId& mesh) const { return orderOf(done_, mesh); }
  std::uint64_t redoOrder(const MeshId& mesh) const { return orderOf(undone_, mesh); }

  /// Takes these out. There has to be one.
  LabelStep takeDone(const MeshId& mesh) { return take(done_, mesh); }
  LabelStep takeUndone(const MeshId& mesh) { return take(undone_, mesh); }

  void forgetUndoneBefore(const MeshId& mesh, std::uint64_t order);

 private:
  using Steps = std::deque<LabelStep>;

  static std::uint64_t orderOf(const Steps& steps, const MeshId& mesh);
  static LabelStep take(Steps& steps, const MeshId& mesh);
  void put(Steps& steps, LabelStep step);

  std::size_t bytes_;
  Steps done_;
  Steps undone_;
  std::deque<MeshId> meshes_;  ///< of which there are steps, the one edited last behind
};

}  // namespace rviz_mesh_plugin
