#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <QPointer>

#include "base/step_history.h"
#include "displays/cluster_label_display.h"
#include "label_editing/edit_command_queue.h"
#include "label_editing/edit_delivery.h"
#include "label_editing/label_files.h"
#include "label_editing/label_history.h"
#include "label_editing/label_saving.h"
#include "label_editing/pending_edits.h"
#include "labels/given_faces.h"
#include "labels/label_faces.h"

namespace rviz {
class DisplayContext;
}

namespace rviz_mesh_plugin {

/// Edits the labels of one mesh: finds the display that shows them, sends edits through it, follows
/// them until they are stored and then saved in the map. GUI thread only; nothing here waits.
///
/// Functions that edit return why they cannot, else an empty string. What they were asked for is
/// kept until it is stored, even where nobody listens, the display is gone, or the mesh changes.
/// What has to look at more than MANY_FACES is made ready on a thread; edits are made in the order
/// in which they were asked for. Each is a step, which can be undone by edits that put the labels
/// back as they were, unless somebody else has changed them since.
class LabelSession : public StepHistory
{
 public:
  using Faces = std::vector<std::uint32_t>;

  /// @param context whose displays show labels; where it goes before this, none does
  /// @param patience until an edit that was sent should be stored
  explicit LabelSession(rviz::DisplayContext* context,
                        std::chrono::milliseconds patience = std::chrono::seconds(10));
  ~LabelSession() override;

  /// To be called often.
  /// @param mesh whose labels are to be edited; null: of the first display that has one
  void work(const MeshDataConstPtr& mesh);

  ClusterLabelDisplay* display() const { return display_; }
  MeshDataConstPtr mesh() const { return display_ ? display_->mesh() : nullptr; }
  /// Whether that is this one.
  bool isOf(const MeshDataConstPtr& mesh) const;
  /// Another number wherever labels, edits or what is saved may have changed.
  std::size_t revision() const { return revision_; }
  /// As they are stored.
  const LabelClusters& labels() const;
  /// Whether there are no others; false while those who store them have not said what there is.
  bool labelsKnown() const;
  /// As it is drawn; nothing where there is no display.
  std::optional<Rgba8> color(const std::string& label) const;
  /// All labels that are stored or are to be.
  std::vector<std::string> names() const;
  /// Of a label, as they are to be; not null.
  LabelFacesConstPtr faces(const std::string& label) const;
  std::size_t faceCount(const std::string& label) const { return faces(label)->size(); }
  /// All of it as it is now, with what is not stored yet; to be made on any thread.
  std::function<FileLabels()> content() const;

  std::string assign(const std::string& label, const GivenFaces& faces);
  /// Those that others add at the same time stay.
  std::string add(const std::string& label, const GivenFaces& faces);
  std::string takeAway(const std::string& label, const GivenFaces& faces);
  /// Keeps a color of the label's own. The old label goes when the new one is stored, unless it
  /// has changed by then.
  std::string rename(const std::string& from, const std::string& to);
  /// Into one of them. The others go when that is stored, unless they have changed by then.
  std::string merge(const std::vector<std::string>& labels, const std::string& into);
  std::string remove(const std::vector<std::string>& labels);
  /// Nothing: the color of its class.
  std::string setColor(const std::vector<std::string>& labels, const std::optional<Rgba8>& color);
  /// Labels of those names become what they are there; others stay.
  std::string import(const std::shared_ptr<const FileLabels>& labels);

  /// Edits are being made ready; those of another mesh wait for that.
  bool busy() const { return commands_.isBusy(id()); }
  /// Of the newest of these functions that was called, see step_history.h.
  std::uint64_t newestOrder() const { return newest_order_; }

  std::uint64_t undoOrder() const override { return history_.undoOrder(id()); }
  std::uint64_t redoOrder() const override { return history_.redoOrder(id()); }
  std::string whyNotNow() const override;
  std::string undo() override { return step(true); }
  std::string redo() override { return step(false); }
  void forgetUndoneBefore(std::uint64_t order) override
  {
    history_.forgetUndoneBefore(id(), order);
  }

  /// Edits that are not stored.
  std::size_t unstored() const { return edits_.count() + commands_.count(); }
  /// Of these, those that do not go on by themselves.
  std::size_t failed() const { return edits_.failed() + commands_.held().size(); }
  bool isUnstored(const std::string& label) const;
  /// Labels that were stored since they were saved last.
  std::size_t unsaved() const { return saving_.count(); }
  bool isUnsaved(const std::string& label) const;
  /// Why something is not stored, saved or undone; else empty.
  std::string failure() const;
  void sendAgain();
  /// Forgets edits that are not stored.
  void giveUp();

  /// Asks those who store labels to write them into the maps, all at the same time.
  std::string save() { return saving_.save(nameSpace()); }
  bool isSaving() const { return saving_.isSaving(); }

 private:
  using Edits = std::vector<LabelEdit>;
  using Plan = EditPlan;

  /// While this lives, it is that mesh whose labels are edited, where a display shows it.
  class OtherMesh;

  std::string perform(const std::string& what, std::function<Plan()> begin);
  std::string perform(EditCommand command);
  Plan begin(EditCommand& command);
  std::string finish(const EditCommand& command, Edits edits);
  std::string step(bool undo);
  std::string whyNotBack(const LabelStep& step, bool undo) const;
  OptionalStatus status() const;
  LabelState state(const std::string& label) const;
  LabelFacesConstPtr stored(const std::string& label) const;
  FaceParentsConstPtr parents() const { return display_ ? display_->faceParents() : nullptr; }

  MeshId id() const;
  LabelEdit edit(const std::string& label) const;
  LabelEdit facesEdit(const std::string& label, LabelFacesConstPtr faces) const;
  LabelEdit colorEdit(const std::string& label, const std::optional<Rgba8>& color) const;
  LabelEdit clearing(const std::string& label, const std::string& after) const;
  /// Of any mesh; null: no display shows it.
  ClusterLabelDisplay* displayOf(const MeshId& mesh) const;
  std::string whyNotShown(const MeshId& mesh) const;
  /// Of who stores the labels that are edited.
  std::string nameSpace() const;
  void showEdits(const OptionalStatus& status);

  QPointer<rviz::DisplayContext> context_;
  QPointer<ClusterLabelDisplay> display_;
  bool shows_edits_ = false;  ///< there, of this session
  PendingEdits edits_;
  EditDelivery delivery_;
  LabelSaving saving_;
  LabelHistory history_;
  EditCommandQueue commands_;
  std::string command_failure_;
  std::uint64_t newest_order_ = 0;
  std::size_t revision_ = 0;
  LabelClusters known_;  ///< at that revision
};

}  // namespace rviz_mesh_plugin
