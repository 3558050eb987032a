#pragma once

#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <rviz/viewport_mouse_event.h>

#include "picking/surface_picker.h"
#include "selection/selection_gestures.h"
#include "selection/selection_regions.h"
#include "threads/work_thread.h"
#include "tools/selection/selection_properties.h"
#include "tools/selection/selection_session.h"

namespace rviz_mesh_plugin {

class FaceNeighbors;

/// Selects what is clicked at or dragged over in a picture. Texts that are returned tell the user
/// what went otherwise than expected, and are empty where nothing did. Whatever takes long is done
/// on a thread and taken over by frame(). GUI thread only.
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

  std::string change(const std::function<const FaceSelection::Change&(FaceSelection&)>& make);
  /// All faces of the mesh; before there is a selection, of the first that is shown.
  std::string selectAll();
  std::string replace(const MeshDataConstPtr& mesh, const FaceSelection::Faces& faces);
  /// Adds the ring of faces around the selection, or takes away its outermost one.
  std::string growOrShrink(bool grow);

  bool busy() const { return !questions_.empty(); }

  /// Takes back the stroke, and forgets what is being looked for. Returns whether there was any.
  bool giveUp();

  /// Begins what has to be ready before the first click, besides what the picker needs.
  void prepare(const SelectionSettings& settings);

  struct FrameResult
  {
    std::string text;
    bool mesh_gone = false;
  };
  /// To be called each frame.
  FrameResult frame();

 private:
  struct Target
  {
    FaceSearch search;   ///< without regions
    std::string reason;  ///< why there is none
  };

  /// Faces that are being looked for, to be selected or deselected.
  struct Question
  {
    MeshDataConstPtr mesh;
    bool adding = true;
    std::future<FaceSelection::Faces> faces;
  };

  /// Null: `reason` says why they are not known.
  static std::shared_ptr<const FaceNeighbors> neighborsOf(const MeshDataConstPtr& mesh,
                                                          std::string& reason);
  FaceSearch makeSearch(const Event& event, const ShownMesh& shown,
                        const SelectionSettings& settings) const;
  Target selectedTarget(const Event& event, const SelectionSettings& settings) const;
  Target findTarget(const Event& event, const Gesture& gesture, const std::vector<Pixel>& path,
                    const SelectionSettings& settings) const;
  std::string flood(const SurfaceHit& hit, bool adding, const SelectionSettings& settings);
  std::string apply(const MeshDataConstPtr& mesh, bool adding, const FaceSelection::Faces& faces);
  std::string search(FaceSearch search, bool adding, bool on_thread);
  void ask(const MeshDataConstPtr& mesh, bool adding,
           std::function<FaceSelection::Faces(const std::atomic<bool>& cancel)> work);
  std::string takeAnswer();
  FrameResult dropLostMesh();
  std::string takeReturnedMesh();
  void finishStroke();

  rviz::DisplayContext* context_;
  const SurfacePicker& picker_;
  SelectionSession session_;
  std::deque<Question> questions_;  ///< answered in this order
  WorkThread thread_{"selection"};
  std::optional<SurfaceHit> brush_;
  bool stroking_ = false;
  bool stroke_ending_ = false;    ///< with the last answer
  MeshDataConstPtr stroke_mesh_;  ///< null: it has not touched any
};

}  // namespace rviz_mesh_plugin
