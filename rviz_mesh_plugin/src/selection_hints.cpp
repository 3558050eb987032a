#include "rviz_mesh_plugin/selection_hints.h"

namespace rviz_mesh_plugin {
namespace {

const char* mouseHint(SelectionTechnique technique)
{
  switch (technique) {
    case SelectionTechnique::LASSO:
      return "<b>Left drag:</b> lasso to select. <b>Right drag:</b> to deselect.";
    case SelectionTechnique::FLOOD:
      return "<b>Left click:</b> select the connected region. <b>Right click:</b> deselect it.";
    case SelectionTechnique::LABEL:
      return "<b>Left click:</b> select the faces of a label. <b>Right click:</b> deselect them.";
    default:
      return "<b>Left drag:</b> box to select. <b>Right drag:</b> to deselect. <b>Click:</b> one "
             "face.";
  }
}

}  // namespace

QString selectionHint(const SelectionState& state, const SelectionSettings& settings)
{
  QString text;
  if (state.busy) {
    text = settings.visible_only ? "Looking which faces are seen ... <b>Esc:</b> give up. "
                                 : "Looking for the faces ... <b>Esc:</b> give up. ";
  } else if (!state.message.empty()) {
    QString message = QString::fromStdString(state.message);
    message[0] = message[0].toUpper();
    text = message.toHtmlEscaped() + ". ";
  }
  if (state.count == 0) {
    text += "No faces are selected. ";
  } else {
    text += QString(state.count == 1 ? "%1 face is selected, " : "%1 faces are selected, ")
                .arg(state.count);
    text += state.area ? QString("%1 m². ").arg(*state.area, 0, 'g', 4) : "... m². ";
  }
  if (state.brush) {
    return text + QString(
                      "<b>Ctrl + drag:</b> brush of %1 m, right to deselect. <b>Ctrl + "
                      "wheel:</b> its radius.")
                      .arg(settings.radius, 0, 'g', 3);
  }
  return text + mouseHint(settings.technique) +
         " <b>Ctrl:</b> brush. <b>Shift, middle, wheel:</b> view. <b>1-4:</b> mode. <b>Enter:</b> "
         "label.";
}

}  // namespace rviz_mesh_plugin
