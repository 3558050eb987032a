#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <rviz/viewport_mouse_event.h>

#include "base/step_history.h"
#include "labels/label_faces.h"
#include "picking/surface_picker.h"
#include "selection/selection_gestures.h"
#include "selection/selection_regions.h"
#include "tools/selection/edit_queue.h"
#include "tools/selection/selection_properties.h"
#include "tools/selection/selection_session.h"

namespace rviz_mesh_plugin {

class BrushStroke;
class FaceNeighbors;
class FaceHiding;
class SelectableFaces;

/// Selects what is clicked at or dragged over in a picture. Texts that are returned tell the user
/// what went otherwise than expected, and are empty where nothing did. GUI thread only.
///
/// What has to look at more than MANY_FACES is done on a thread and taken over by frame(). Edits
/// change the selection one after the other, in the order in which they were asked for: those that
/// come while faces are being looked for wait for their turn. What is pointed at is found then: in
/// the picture of the event, of what the edits before it have left shown. giveUp() drops all that
/// wait.
///
/// Faces are of one mesh: whoever adds faces of another one loses those that were selected. Where
/// the mesh goes and the same returns, as after Reset, they are selected again.
class SelectionEditor
{
 public:
  using Event = rviz::ViewportMouseEvent;

  /// @param picker outlives this
  /// @param on_change is called where the selection has changed
  SelectionEditor(rviz::DisplayContext* context, const SurfacePicker& picker,
                  const std::function<void()>& on_change);

  SelectionSession& session() { return session_; }
  const SelectionSession& session() const { return session_; }

  /// The mesh that has the selection once the edits that wait have been made, as far as that is
  /// known before their turn, else the first that is shown; none where it is hidden.
  std::optional<ShownMesh> shownMesh() const;

  /// What is under the cursor.
  std::string click(const Event& event, const Gesture& gesture, const SelectionSettings& settings);
  /// A box or a lasso. @param path of the gesture
  std::string area(const Event& event, const Gesture& gesture, const std::vector<Pixel>& path,
                   const SelectionSettings& settings);

  /// With the brush: all of a stroke is one step to undo.
  void beginStroke();
  /// From one place of the cursor to the next. All of it is on the mesh that was hit first.
  std::string stroke(const Event& event, const Gesture& gesture, const SelectionSettings& settings);
  void endStroke();

  /// Where the brush is; none where it is not on a surface.
  const std::optional<SurfaceHit>& brush() const { return brush_; }
  void findBrush(const Event& event, const SelectionSettings& settings);

  using Make = SelectionSession::Make;
  std::string change(const Make& make);
  /// All faces of the mesh that can be selected (SelectableFaces); before there is a selection, of
  /// the first that is shown.
  std::string selectAll();
  /// Those of them that are not selected, instead of those that are.
  std::string invert();
  /// @param faces of each of these
  /// Also of those that are not shown, so that labels that are made of them lose nothing.
  std::string replace(const MeshDataConstPtr& mesh, const std::vector<LabelFacesConstPtr>& faces);

  /// Finds faces of a mesh; owns what it uses, and gives up soon after the flag is set.
  using FindFaces = std::function<FaceBits(const std::atomic<bool>& cancel)>;
  /// Puts faces together with the selection, as one step to undo. They are looked for on the
  /// thread, with their turn.
  std::string combine(const MeshDataConstPtr& mesh, Combination how, const FindFaces& find);

  /// Hides the selected faces, or all others: they are not drawn in any display, and cannot be
  /// pointed at or selected, until showAll(). Who hides what is selected deselects it. All of it is
  /// one step to undo.
  std::string hide() { return hide(false); }
  std::string isolate() { return hide(true); }
  /// Of all meshes that are shown.
  std::string showAll();
  std::size_t hiddenCount() const;

  /// The newest step of the selection, or of another history that is newer.
  std::string undo() { return step(true); }
  std::string redo() { return step(false); }
  /// Its steps are undone and redone in one order with those of the selection.
  void addHistory(const std::shared_ptr<StepHistory>& history) { histories_.add(history); }
  /// Adds the ring of faces around the selection, or takes away its outermost one.
  std::string growOrShrink(bool grow);

  /// Edits wait: for faces that are being looked for, or for their turn.
  bool busy() const { return !queue_.empty(); }
  std::size_t waiting() const { return queue_.size(); }

  /// Takes back the stroke, and forgets what is being looked for. Returns whether there was any.
  bool giveUp();

  /// Begins what has to be ready before the first click, besides what the picker needs.
  void prepare(const SelectionSettings& settings);

  struct FrameResult
  {
    std::optional<std::string> text;  ///< none: the last one still holds
    bool mesh_gone = false;
  };
  /// To be called each frame.
  FrameResult frame();

 private:
  using Edit = EditQueue::Edit;
  using Found = EditQueue::Found;

  /// Null: they are not known yet, or `failure` says why they will not be.
  static std::shared_ptr<const FaceNeighbors> neighborsOf(const MeshDataConstPtr& mesh,
                                                          std::string& failure);
  MeshDataConstPtr comingMesh() const;
  SelectableFaces selectableOf(const MeshDataConstPtr& mesh) const;
  using ChangeAmong =
      std::function<const FaceSelection::Change&(FaceSelection& selection, const FaceBits& faces)>;
  std::string changeSelectable(const Make& all, const ChangeAmong& among, bool of_first_mesh);
  std::string beginClick(Edit& edit, const Event& event, bool adding,
                         const SelectionSettings& settings);
  std::string beginFlood(Edit& edit, const Event& event, const SurfaceHit& hit, bool adding,
                         const SelectionSettings& settings);
  void putLabel(Edit& edit, const Event& event, const SurfaceHit& hit, bool adding,
                LabelFacesConstPtr faces, const SelectionSettings& settings);
  std::string beginArea(Edit& edit, const Event& event, const Gesture& gesture,
                        const std::vector<Pixel>& path, const SelectionSettings& settings);
  std::string beginMoves(Edit& edit, bool adding);
  std::string step(bool undo);
  std::string hide(bool others);
  void put(Edit& edit, const MeshDataConstPtr& mesh, bool adding, LabelFacesConstPtr faces);
  std::string apply(const MeshDataConstPtr& mesh, bool adding, const Make& make);
  std::string takeFound(bool adding, const std::string& nothing, const Found& found);
  std::string search(Edit& edit, std::vector<FaceSearch> searches, bool adding,
                     const std::string& nothing);
  static Found find(const std::vector<FaceSearch>& searches, const std::atomic<bool>& cancel);
  FrameResult dropLostMesh();
  std::string takeReturnedMesh();

  rviz::DisplayContext* context_;
  const SurfacePicker& picker_;
  SelectionSession session_;
  std::shared_ptr<FaceHiding> hiding_;
  StepHistories histories_;  ///< of others than the selection
  EditQueue queue_;
  std::optional<SurfaceHit> brush_;
  std::shared_ptr<BrushStroke> stroke_;  ///< null: the button is up; the edits may be behind
};

}  // namespace rviz_mesh_plugin
