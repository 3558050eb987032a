#include "panel/label_actions.h"

#include <array>

namespace rviz_mesh_plugin {
namespace {

struct Words
{
  const char* text;
  const char* tip;
};

constexpr std::array<Words, static_cast<std::size_t>(LabelAction::COUNT)> WORDS = {{
    {"Label Cluster", "Labels the selected faces with the name above."},
    {"Reset Faces", "Selects nothing."},
    {"New…", "Labels the selected faces: asks for class and instance (Enter in the view)."},
    {"Assign", "Gives the label the selected faces instead of those it has."},
    {"Add", "Adds the selected faces to the label."},
    {"Take Away", "Takes the selected faces away from the label."},
    {"Select Faces", "Selects the faces of these labels."},
    {"Rename…", "Gives the label another name."},
    {"Merge…", "Makes one label of these."},
    {"Delete…", "Deletes these labels."},
    {"Color…", "Gives these labels a color of their own, or that of their class again."},
    {"Class Color…", "Gives all labels of these classes a color, or takes it away."},
    {"Import…", "Reads labels from a JSON or CSV file."},
    {"Export…", "Writes all labels to a JSON or CSV file."},
    {"Save", "Has the labels written into the map."},
    {"Send Again", "Sends edits again that have not been stored."},
    {"Give Up", "Forgets edits that have not been stored."},
}};

const Words& wordsOf(LabelAction action)
{
  return WORDS.at(static_cast<std::size_t>(action));
}

std::string whyNoSelection(const LabelSituation& situation)
{
  if (!situation.has_tool) {
    return "nothing can be selected: add the tool ClusterLabel with the + of the toolbar";
  }
  if (situation.selected == 0) {
    return "nothing is selected: select faces with the tool ClusterLabel (key l)";
  }
  return situation.selection_is_of_it ? std::string()
                                      : "the selected faces are of a mesh whose labels no display "
                                        "shows: add one for it";
}

std::string counted(std::size_t count, const std::string& what)
{
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

const char* textOf(LabelAction action)
{
  return wordsOf(action).text;
}

const char* tipOf(LabelAction action)
{
  return wordsOf(action).tip;
}

std::string whyNot(LabelAction action, const LabelSituation& situation)
{
  const auto choose = [&](bool one) -> std::string {
    if (one ? situation.chosen == 1 : situation.chosen > 0) {
      return {};
    }
    return one ? "choose one label in the list" : "choose labels in the list";
  };
  const auto first = [](const std::string& a, const std::string& b) { return a.empty() ? b : a; };
  switch (action) {
    case LabelAction::SEND_AGAIN:
    case LabelAction::GIVE_UP:
      return situation.failed > 0 ? "" : "no edit has failed";
    case LabelAction::RESET_FACES:
      return situation.selected > 0 ? "" : "nothing is selected";
    default:
      break;
  }
  if (!situation.has_mesh) {
    return "there is no mesh to label: add a Map3D display, or one of labels with its topics";
  }
  switch (action) {
    case LabelAction::LABEL_CLUSTER:
      return first(situation.name.empty() ? "the field 'Cluster Name' is empty" : "",
                   whyNoSelection(situation));
    case LabelAction::NEW:
      return whyNoSelection(situation);
    case LabelAction::ASSIGN:
    case LabelAction::ADD:
    case LabelAction::TAKE_AWAY:
      return first(whyNoSelection(situation), choose(true));
    case LabelAction::SELECT:
      return first(situation.has_tool ? "" : whyNoSelection(situation), choose(false));
    case LabelAction::RENAME:
      return choose(true);
    case LabelAction::MERGE:
      return situation.chosen > 1 ? "" : "choose two labels or more in the list";
    case LabelAction::DELETE:
    case LabelAction::COLOR:
    case LabelAction::CLASS_COLOR:
      return choose(false);
    case LabelAction::EXPORT:
      return first(situation.labels > 0 ? "" : "there are no labels",
                   situation.file_busy ? "a file is being read or written" : "");
    case LabelAction::IMPORT:
      return situation.file_busy ? "a file is being read or written" : "";
    case LabelAction::SAVE:
      return situation.saving ? "labels are being saved" : "";
    default:
      return {};
  }
}

std::string describe(const LabelSituation& situation)
{
  if (!situation.has_mesh && situation.unstored + situation.unsaved == 0) {
    return "No labels to edit: add a Map3D display, or one of labels with its topics.";
  }
  std::string text = counted(situation.labels, "label");
  if (situation.unstored > 0) {
    text += ", " + counted(situation.unstored, "edit") + " not stored yet";
  }
  if (situation.saving) {
    text += ", saving…";
  } else if (situation.unsaved > 0) {
    text += ", " + counted(situation.unsaved, "label") + " not saved in the map";
  }
  if (situation.file_busy) {
    text += ", a file is being read or written…";
  }
  return text + ".";
}

std::string describeLoss(const LabelSituation& situation)
{
  std::string text;
  if (situation.unsaved > 0) {
    const bool one = situation.unsaved == 1;
    text += counted(situation.unsaved, "label") + (one ? " is" : " are") +
            " not saved in the map, but safe in the journal of the node that stores labels, which "
            "writes " +
            (one ? "it" : "them") + " into the map when it saves next. ";
  }
  if (situation.unstored > 0) {
    text += counted(situation.unstored, "edit") + (situation.unstored == 1 ? " is" : " are") +
            " not stored, and would be lost. ";
  }
  return text;
}

}  // namespace rviz_mesh_plugin
