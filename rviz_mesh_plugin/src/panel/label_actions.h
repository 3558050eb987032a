#pragma once

#include <cstddef>
#include <string>

namespace rviz_mesh_plugin {

/// What the buttons of the panel of labels do.
enum class LabelAction
{
  LABEL_CLUSTER,
  RESET_FACES,
  NEW,
  ASSIGN,
  ADD,
  TAKE_AWAY,
  SELECT,
  RENAME,
  MERGE,
  DELETE,
  COLOR,
  CLASS_COLOR,
  IMPORT,
  EXPORT,
  SAVE,
  SEND_AGAIN,
  GIVE_UP,
  COUNT
};

/// What decides which of them are possible.
struct LabelSituation
{
  bool has_tool = false;
  bool has_mesh = false;           ///< whose labels are edited
  bool selection_is_of_it = true;  ///< and not of another mesh
  std::size_t selected = 0;        ///< faces
  std::string name;                ///< in the field "Cluster Name"
  std::size_t labels = 0;          ///< in the list
  std::size_t chosen = 0;          ///< of these
  std::size_t unstored = 0;
  std::size_t failed = 0;
  std::size_t unsaved = 0;
  bool saving = false;
  bool file_busy = false;  ///< one is being read or written
};

/// On the button.
const char* textOf(LabelAction action);
/// What it does, in a sentence.
const char* tipOf(LabelAction action);
/// Why it is not possible, with the way out; empty if it is.
std::string whyNot(LabelAction action, const LabelSituation& situation);

/// One line on the labels and on what is not stored or saved.
std::string describe(const LabelSituation& situation);

/// What becomes of that where RViz is closed now.
std::string describeLoss(const LabelSituation& situation);

}  // namespace rviz_mesh_plugin
