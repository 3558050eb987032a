#pragma once

#include <qnamespace.h>

namespace rviz_mesh_plugin {

/// What a key means while faces are being selected.
enum class SelectionKey
{
  NONE,
  UNDO,
  REDO,
  ALL,
  CLEAR,
  INVERT,
  GROW,
  SHRINK,
  BOX,  ///< this and those of the other techniques are in their order
  LASSO,
  FLOOD,
  LABEL,
  HIDE,
  ISOLATE,
  SHOW_ALL,
  TOGGLE_VISIBLE_ONLY,
  TOGGLE_BACK_FACES,
  REQUEST_LABEL,
  GIVE_UP
};

/// @param key of Qt::Key
SelectionKey selectionKey(int key, Qt::KeyboardModifiers modifiers);

}  // namespace rviz_mesh_plugin
