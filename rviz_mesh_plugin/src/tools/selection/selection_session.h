#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/mesh_data.h"
#include "base/step_history.h"
#include "selection/face_selection.h"
#include "selection/selection_visual.h"

namespace rviz_mesh_plugin {

/// The selected faces of one mesh with their highlight. GUI thread only.
class SelectionSession : public StepHistory
{
 public:
  SelectionSession(Ogre::SceneManager* scene_manager, const std::function<void()>& on_change);

  /// Null: none yet.
  const MeshDataConstPtr& mesh() const { return mesh_; }
  const FaceSelection& selection() const { return selection_; }
  /// Of the selected faces, in square meters; none while follow() is still adding up.
  std::optional<double> area() const;
  const SelectionVisual& visual() const { return visual_; }
  void setColor(const Rgba8& color) { visual_.setColor(color); }

  /// From now on faces of this mesh (null: of none) are selected. Where it is another one, nothing
  /// is selected and nothing can be undone; but where it is the one awaited, with the same vertices
  /// and faces, all is as it was.
  void setMesh(const MeshDataConstPtr& mesh);

  /// The mesh is gone, for now: what is selected and can be undone is kept for when it returns.
  void setAside();
  /// The mesh whose return is waited for; null: none.
  const MeshDataConstPtr& awaited() const { return awaited_; }
  bool isAwaited(const MeshData& mesh) const;
  void forgetAwaited();

  using Make = std::function<const FaceSelection::Change&(FaceSelection&)>;
  /// Changes the selection, and the highlight with it; returns whether anything has changed.
  /// @throw std::bad_alloc before, and Ogre::Exception after the selection has changed
  bool change(const Make& make);

  /// See FaceSelection.
  void beginStroke() { selection_.beginStroke(); }
  void endStroke() { selection_.endStroke(); }

  std::uint64_t undoOrder() const override { return selection_.undoOrder(); }
  std::uint64_t redoOrder() const override { return selection_.redoOrder(); }
  std::string whyNotNow() const override { return {}; }
  /// They tell nothing: what is selected is seen. As change().
  std::string undo() override;
  std::string redo() override;
  void forgetUndoneBefore(std::uint64_t order) override { selection_.forgetUndoneBefore(order); }

  /// To be called each frame. @throw Ogre::Exception, std::bad_alloc
  void follow(const std::vector<ShownMesh>& shown);

 private:
  void countChange(const FaceSelection::Change& change);
  void count();
  void showChange(const FaceSelection::Change& change);

  std::function<void()> on_change_;
  MeshDataConstPtr mesh_;
  FaceSelection selection_;
  MeshDataConstPtr awaited_;
  FaceSelection awaited_selection_;
  double area_ = 0.0;
  std::uint32_t counted_ = 0;  ///< faces of the mesh whose area is in it
  SelectionVisual visual_;
  bool visual_failed_ = false;  ///< it does not show what is selected
};

}  // namespace rviz_mesh_plugin
