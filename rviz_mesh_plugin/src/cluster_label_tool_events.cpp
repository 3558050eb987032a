#include <algorithm>
#include <cmath>

#include <OgreViewport.h>
#include <rviz/display_context.h>
#include <rviz/render_panel.h>
#include <rviz/tool_manager.h>
#include <rviz/view_controller.h>
#include <rviz/viewport_mouse_event.h>
#include <QKeyEvent>
#include <QKeySequence>

#include "rviz_mesh_plugin/brush_ball.h"
#include "rviz_mesh_plugin/cluster_label_tool.h"
#include "rviz_mesh_plugin/screen_outline.h"
#include "rviz_mesh_plugin/selection_editor.h"

namespace rviz_mesh_plugin {
namespace {

/// Of the brush's radius, per notch of the wheel.
constexpr double RADIUS_FACTOR = 1.1;

MouseInput inputOf(const rviz::ViewportMouseEvent& event)
{
  MouseInput input;
  input.at = {event.x, event.y};
  input.button = event.acting_button;
  input.down = event.buttons_down;
  input.modifiers = event.modifiers;
  switch (event.type) {
    case QEvent::MouseButtonPress:
    case QEvent::MouseButtonDblClick:  // the second of two quick presses
      input.type = MouseInput::PRESS;
      break;
    case QEvent::MouseButtonRelease:
      input.type = MouseInput::RELEASE;
      break;
    case QEvent::Wheel:
      input.type = MouseInput::WHEEL;
      input.wheel = event.wheel_delta;
      break;
    default:
      break;
  }
  return input;
}

bool hasPicture(const rviz::ViewportMouseEvent& event)
{
  const Ogre::Viewport* viewport = event.viewport;
  return viewport && viewport->getCamera() && viewport->getActualWidth() > 0 &&
         viewport->getActualHeight() > 0;
}

}  // namespace

int ClusterLabelTool::processMouseEvent(rviz::ViewportMouseEvent& event)
{
  int result = 0;
  attempt([&] {
    if (editor_ && hasPicture(event)) {
      result = handle(event);
    }
  });
  return result;
}

int ClusterLabelTool::handle(rviz::ViewportMouseEvent& event)
{
  const SelectionSettings settings = properties_->settings();
  const double area =
      static_cast<double>(event.viewport->getActualWidth()) * event.viewport->getActualHeight();
  const Gesture gesture = gestures_.handle(inputOf(event), settings.technique, area);
  const bool begins =
      event.type == QEvent::MouseButtonPress || event.type == QEvent::MouseButtonDblClick;
  if (begins && gestures_.isDragging()) {
    message_.clear();
    if (busy()) {
      gestures_.giveUp();
      say(STILL_LOOKING);
      return Render;
    }
  }
  switch (gesture.kind) {
    case Gesture::NOTHING:
      return 0;
    case Gesture::CAMERA:
      moveCamera(event);
      return Render;
    case Gesture::HOVER:
      return hover(event, gesture.brush) ? Render : 0;
    case Gesture::OUTLINE:
      ball_->hide();
      showOutline(event);
      return Render;
    case Gesture::RADIUS:
      properties_->scaleRadius(std::pow(RADIUS_FACTOR, gesture.notches));
      hover(event, true);
      return Render;
    case Gesture::GIVE_UP:
      giveUp();
      return Render;
    default:
      break;
  }
  outline_->hide();
  select(event, gesture);
  return Render;
}

void ClusterLabelTool::select(const rviz::ViewportMouseEvent& event, const Gesture& gesture)
{
  SelectionSettings settings = properties_->settings();
  settings.technique = gestures_.technique();  // as when the drag began
  std::string text;
  switch (gesture.kind) {
    case Gesture::CLICK:
      text = editor_->click(event, gesture, settings);
      break;
    case Gesture::BOX:
      text = editor_->box(event, gesture, settings);
      break;
    case Gesture::LASSO:
      text = editor_->lasso(event, gesture, gestures_.path(), settings);
      break;
    case Gesture::STROKE_BEGIN:
      editor_->beginStroke();
      text = editor_->stroke(event, gesture, settings);
      break;
    case Gesture::STROKE:
      text = editor_->stroke(event, gesture, settings);
      break;
    case Gesture::STROKE_END:
      text = editor_->stroke(event, gesture, settings);
      editor_->endStroke();
      break;
    default:
      break;
  }
  if (gesture.kind == Gesture::STROKE_BEGIN || gesture.kind == Gesture::STROKE ||
      gesture.kind == Gesture::STROKE_END) {
    showBall(gesture.adding);
  }
  message_ = text;
  showStatus();
}

/// Returns whether there is anything new to be seen.
bool ClusterLabelTool::hover(const rviz::ViewportMouseEvent& event, bool brush)
{
  const bool was_shown = ball_->isShown();
  if (brush) {
    editor_->findBrush(event, properties_->settings());
    showBall(!gestures_.isDragging() || gestures_.isAdding());
  } else {
    ball_->hide();
  }
  showStatus();
  return was_shown || ball_->isShown();
}

void ClusterLabelTool::showBall(bool adding)
{
  if (const auto& hit = editor_->brush()) {
    ball_->show(pointInFixedFrame(hit->point, *hit), properties_->settings().radius, adding);
  } else {
    ball_->hide();
  }
}

void ClusterLabelTool::showOutline(const rviz::ViewportMouseEvent& event)
{
  const auto& path = gestures_.path();
  if (gestures_.technique() == SelectionTechnique::LASSO) {
    outline_->show(*event.viewport, path);
  } else if (gestures_.technique() == SelectionTechnique::BOX && path.size() > 1) {
    outline_->showBox(*event.viewport, path.front(), path.back());
  }
}

/// Shift with left or right is what these buttons do without it in RViz's other tools.
void ClusterLabelTool::moveCamera(const rviz::ViewportMouseEvent& event)
{
  rviz::ViewController* view = event.panel ? event.panel->getViewController() : nullptr;
  if (!view) {
    return;
  }
  ball_->hide();
  rviz::ViewportMouseEvent passed = event;
  const bool middle =
      event.acting_button == Qt::MiddleButton || (event.buttons_down & Qt::MiddleButton) != 0;
  if (!middle && event.type != QEvent::Wheel) {
    passed.modifiers &= ~Qt::KeyboardModifiers(Qt::ShiftModifier);
  }
  view->handleMouseEvent(passed);
  status_.clear();  // the view has its own
}

int ClusterLabelTool::processKeyEvent(QKeyEvent* event, rviz::RenderPanel* panel)
{
  bool used = false;
  attempt([&] {
    if (!editor_ || !event) {
      return;
    }
    const SelectionKey key = selectionKey(event->key(), event->modifiers());
    used = key != SelectionKey::NONE;
    if (used) {
      press(key);
    } else if (!switchTool(*event) && panel && panel->getViewController()) {
      panel->getViewController()->handleKeyEvent(event, panel);
    }
  });
  return used ? Render : 0;
}

/// This tool is given all keys, and hands on those of other tools.
bool ClusterLabelTool::switchTool(const QKeyEvent& event)
{
  rviz::ToolManager* tools = context_->getToolManager();
  if ((event.modifiers() & (Qt::ControlModifier | Qt::AltModifier | Qt::MetaModifier)) != 0) {
    return false;
  }
  // Of several with one key it is the last, as in RViz.
  for (int i = tools ? tools->numTools() - 1 : -1; i >= 0; --i) {
    rviz::Tool* tool = tools->getTool(i);
    const QKeySequence shortcut{QString(QChar(tool->getShortcutKey()))};
    if (tool->getShortcutKey() != '\0' && shortcut.count() == 1 && shortcut[0] == event.key()) {
      tools->setCurrentTool(tool);
      return true;
    }
  }
  return false;
}

}  // namespace rviz_mesh_plugin
