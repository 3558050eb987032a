#include "rviz_mesh_plugin/cluster_label_tool.h"
#include "rviz_mesh_plugin/selection_editor.h"

namespace rviz_mesh_plugin {
namespace {

using Change = FaceSelection::Change;

}  // namespace

void ClusterLabelTool::press(SelectionKey key)
{
  if (key == SelectionKey::GIVE_UP) {
    giveUp();
    return;
  }
  if (gestures_.isDragging()) {
    return;  // until the button is released
  }
  if (!pressForSettings(key)) {
    say(busy() ? STILL_LOOKING : pressForFaces(key));
  }
}

bool ClusterLabelTool::pressForSettings(SelectionKey key)
{
  switch (key) {
    case SelectionKey::BOX:
      properties_->setTechnique(SelectionTechnique::BOX);
      return true;
    case SelectionKey::LASSO:
      properties_->setTechnique(SelectionTechnique::LASSO);
      return true;
    case SelectionKey::FLOOD:
      properties_->setTechnique(SelectionTechnique::FLOOD);
      return true;
    case SelectionKey::LABEL:
      properties_->setTechnique(SelectionTechnique::LABEL);
      return true;
    case SelectionKey::TOGGLE_VISIBLE_ONLY:
      properties_->toggleVisibleOnly();
      say(properties_->settings().visible_only ? "only faces that are seen are selected"
                                               : "faces are selected through the mesh");
      return true;
    case SelectionKey::TOGGLE_BACK_FACES:
      properties_->toggleBackFaces();
      say(properties_->settings().back_faces ? "faces seen from behind are selected, too"
                                             : "faces seen from behind are not selected");
      return true;
    default:
      return false;
  }
}

/// Returns what to tell the user.
std::string ClusterLabelTool::pressForFaces(SelectionKey key)
{
  switch (key) {
    case SelectionKey::UNDO:
      return selection().canUndo()
                 ? editor_->change([](FaceSelection& s) -> const Change& { return s.undo(); })
                 : "there is nothing to undo";
    case SelectionKey::REDO:
      return selection().canRedo()
                 ? editor_->change([](FaceSelection& s) -> const Change& { return s.redo(); })
                 : "there is nothing to redo";
    case SelectionKey::ALL:
      return editor_->selectAll();
    case SelectionKey::CLEAR:
      return editor_->change([](FaceSelection& s) -> const Change& { return s.clear(); });
    case SelectionKey::INVERT:
      return editor_->change([](FaceSelection& s) -> const Change& { return s.invert(); });
    case SelectionKey::GROW:
      return editor_->growOrShrink(true);
    case SelectionKey::SHRINK:
      return editor_->growOrShrink(false);
    case SelectionKey::REQUEST_LABEL:
      if (selection().empty()) {
        return "select faces first, to label them";
      }
      Q_EMIT labelRequested();
      return {};
    default:
      return {};
  }
}

}  // namespace rviz_mesh_plugin
