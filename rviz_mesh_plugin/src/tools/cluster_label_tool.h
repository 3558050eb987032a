#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#ifndef Q_MOC_RUN
#include "base/mesh_data.h"
#include "base/step_history.h"
#include "labels/label_faces.h"
#include "mesh_view/shown_mesh.h"
#include "picking/layer_lookup.h"
#include "selection/face_criterion.h"
#include "selection/face_selection.h"
#include "selection/selection_gestures.h"
#include "tools/selection/selection_keys.h"
#include "tools/selection/selection_properties.h"
#include "tools/surface_tool.h"
#endif

namespace rviz {
class Shape;
}

namespace rviz_mesh_plugin {

class ScreenOutline;
class SelectionEditor;
class SelectionVisual;

/// Selects faces of a mesh that is shown: by box, lasso, brush, connected region or label, to be
/// labelled. What is selected stays, and stays highlighted, while other tools are used, until the
/// mesh is gone.
class ClusterLabelTool : public SurfaceTool
{
  Q_OBJECT

 public:
  ClusterLabelTool();
  ~ClusterLabelTool() override;

  /// Whose faces are selected, or will be with the next click; null: that is not known yet, or the
  /// mesh is gone.
  MeshDataConstPtr mesh() const;
  const FaceSelection& selection() const;

  /// Selects these faces instead of those that are, as one step to undo. Returns why not, else an
  /// empty string.
  std::string select(const MeshDataConstPtr& mesh, const FaceSelection::Faces& faces)
  {
    return selectLabels(mesh, {labelFaces(faces)});
  }
  /// The same for the faces of several labels, which are not copied.
  std::string selectLabels(const MeshDataConstPtr& mesh,
                           const std::vector<LabelFacesConstPtr>& faces);
  /// A step to undo. @param part_of the step of another history with which it is undone
  void clearSelection(const std::optional<std::uint64_t>& part_of = std::nullopt);

  /// Ctrl+Z and its opposite: the newest step, of the selection or of another history. They return
  /// what to tell the user.
  std::string undo();
  std::string redo();
  /// H and its opposites: hides the selected faces, or all others, or shows all again. What they
  /// could not do is told by message().
  void hide();
  void isolate();
  void showAll();
  /// Faces of all meshes that are shown.
  std::size_t hiddenCount() const;
  /// Whose steps are undone in one order with those of the selection; not kept alive.
  void addHistory(const std::shared_ptr<StepHistory>& history);

  /// The mesh whose faces are selected, else the first that is shown; none where there is none, or
  /// it is hidden.
  std::optional<ShownMesh> shownMesh() const;
  /// The cost layers of it that have arrived.
  std::vector<KnownLayer> layersOf(const MeshDataConstPtr& mesh) const;
  QString fixedFrame() const;
  /// Puts the faces of a mesh that meet a criterion together with the selection, as one step to
  /// undo. They are looked for on a thread. Returns why not, else an empty string.
  std::string selectBy(const MeshDataConstPtr& mesh, const FaceCriterion& criterion,
                       Combination how);
  /// What was told last of what has been done; empty where all went as expected.
  const std::string& message() const { return message_; }

  /// An answer is still being computed.
  bool busy() const;
  /// Edits of the selection that wait: for faces that are looked for, or for their turn.
  std::size_t waiting() const;

  /// For tests and benchmarks; null before initialize().
  const SelectionVisual* visual() const;

  int processKeyEvent(QKeyEvent* event, rviz::RenderPanel* panel) override;

 Q_SIGNALS:
  void selectionChanged();
  /// Enter was pressed.
  void labelRequested();

 protected:
  void initializeTool() override;
  void begin() override;
  void end() override;
  void work() override;
  int mouse(rviz::ViewportMouseEvent& event) override;
  /// mouse() tells.
  bool movesCamera(const rviz::ViewportMouseEvent& /*event*/) override { return false; }
  void recover(const std::string& problem) override;

 private:
  static constexpr const char* STILL_LOOKING =
      "faces are still being looked for: wait, or give up with Esc";

  void onFrame();
  void onSettings();
  void select(const rviz::ViewportMouseEvent& event, const Gesture& gesture);
  bool hover(const rviz::ViewportMouseEvent& event, bool brush);
  void showBall(bool adding);
  void showOutline(const rviz::ViewportMouseEvent& event);
  void press(SelectionKey key);
  void pressSafely(SelectionKey key);
  std::string change(SelectionKey key);
  bool switchTool(const QKeyEvent& event);
  void giveUp();
  void tell(const std::string& message);
  void followBrushSize();
  QString hint() const;
  void showStatus();

  SelectionProperties properties_;
  SelectionGestures gestures_;
  std::unique_ptr<SelectionEditor> editor_;
  std::unique_ptr<ScreenOutline> outline_;
  std::unique_ptr<rviz::Shape> ball_;  ///< the brush, where it is seen
  bool active_ = false;
  float brush_size_ = 1.0f;  ///< of the display, as it was last
  std::string message_;
  QString status_;  ///< as shown
};

}  // namespace rviz_mesh_plugin
