#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "base/hidden_faces.h"
#include "base/step_history.h"
#include "mesh_view/shown_mesh.h"

namespace rviz_mesh_plugin {

class SelectionSession;
class SurfacePicker;

/// Hides faces and shows them again, step by step. Where the steps are too many, the oldest are
/// forgotten. Texts that are returned tell the user what has been done, or why not. GUI thread
/// only.
class FaceHiding : public StepHistory
{
 public:
  static constexpr std::size_t BYTES = std::size_t{256} << 20;

  /// @param picker outlives this
  /// @param bytes of steps that are kept; the newest is in any case
  explicit FaceHiding(const SurfacePicker& picker, std::size_t bytes = BYTES)
      : picker_(picker), bytes_(bytes)
  {
  }

  /// What is hidden once these faces are, besides what is; with `others` all faces but these. For a
  /// thread.
  static HiddenFacesConstPtr with(const FaceBits& faces, bool others,
                                  const HiddenFacesConstPtr& before);

  /// Hides no other faces of the mesh of a selection than these: those that are selected are not
  /// any more, which is part of the step.
  std::string hide(const HiddenFacesConstPtr& hidden, SelectionSession& session);
  /// Of all meshes that displays show.
  std::string showAll();
  /// Hidden faces of these.
  std::size_t count() const;

  std::uint64_t undoOrder() const override { return done_.empty() ? 0 : done_.back().order; }
  std::uint64_t redoOrder() const override { return undone_.empty() ? 0 : undone_.back().order; }
  std::string whyNotNow() const override { return {}; }
  /// Where something else has been hidden since, elsewhere, nothing is done.
  std::string undo() override { return move(done_, undone_, true); }
  std::string redo() override { return move(undone_, done_, false); }
  void forgetUndoneBefore(std::uint64_t order) override;

 private:
  /// Of one mesh.
  struct Change
  {
    MeshKey mesh;
    HiddenFacesConstPtr before;
    HiddenFacesConstPtr after;
  };
  struct Step
  {
    std::uint64_t order;
    std::vector<Change> changes;
  };

  std::vector<ShownMesh> meshes() const;
  void perform(Step step);
  std::string move(std::deque<Step>& from, std::deque<Step>& to, bool undo);
  std::size_t bytes() const;

  const SurfacePicker& picker_;
  std::size_t bytes_;
  std::deque<Step> done_;
  std::deque<Step> undone_;
};

}  // namespace rviz_mesh_plugin
