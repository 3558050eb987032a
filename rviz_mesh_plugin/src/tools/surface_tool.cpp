#include "tools/surface_tool.h"

#include <exception>

#include <QKeyEvent>

#include <ros/console.h>
#include <rviz/render_panel.h>
#include <rviz/view_controller.h>
#include <rviz/viewport_mouse_event.h>
#include <rviz/visualization_frame.h>
#include <rviz/visualization_manager.h>

namespace rviz_mesh_plugin {

void SurfaceTool::say(const std::string& text)
{
  said_ = text;
  setStatus(QString::fromStdString(text));
}

/// Later, since who has written something else may not have finished.
void SurfaceTool::sayAgain()
{
  QMetaObject::invokeMethod(
      this,
      [this] {
        if (in_use_ && !said_.empty()) {
          setStatus(QString::fromStdString(said_));
        }
      },
      Qt::QueuedConnection);
}

void SurfaceTool::attempt(const std::function<void()>& work)
{
  try {
    work();
  } catch (const std::exception& error) {
    try {
      ROS_ERROR_THROTTLE(5, "%s: %s", qPrintable(getName()), error.what());
      recover(error.what());
    } catch (const std::exception&) {  // no memory to say so
    }
  }
}

void SurfaceTool::recover(const std::string& problem)
{
  say("Something went wrong: " + problem + "; try again");
}

void SurfaceTool::onInitialize()
{
  attempt([this] {
    picker_ = std::make_unique<SurfacePicker>(context_);
    initializeTool();
    const auto cleared = [this](const QString& text) {
      if (in_use_ && text.isEmpty()) {
        sayAgain();
      }
    };
    // The window's status is the one that is seen; without a window there is the manager's.
    if (auto* frame = dynamic_cast<rviz::VisualizationFrame*>(context_->getWindowManager())) {
      connect(frame, &rviz::VisualizationFrame::statusUpdate, this, cleared);
    } else if (auto* manager = dynamic_cast<rviz::VisualizationManager*>(context_)) {
      connect(manager, &rviz::VisualizationManager::statusUpdate, this, cleared);
    }
  });
}

/// Looks at no display: RViz also calls this while it ends, when they are gone.
void SurfaceTool::activate()
{
  attempt([this] {
    camera_button_ = Qt::NoButton;
    in_use_ = true;
    if (picker_) {
      begin();
      sayAgain();
    }
  });
}

void SurfaceTool::deactivate()
{
  in_use_ = false;
  attempt([this] { end(); });
}

void SurfaceTool::update(float /*wall_dt*/, float /*ros_dt*/)
{
  attempt([this] {
    if (picker_) {
      picker_->prepare();
      work();
    }
  });
}

/// The left button stays with the tool, unless Shift was down when it was pressed.
bool SurfaceTool::movesCamera(const rviz::ViewportMouseEvent& event)
{
  if (event.type == QEvent::Wheel) {
    return true;
  }
  if (event.type == QEvent::MouseButtonPress && camera_button_ == Qt::NoButton) {
    const bool shift_left =
        event.acting_button == Qt::LeftButton && (event.modifiers & Qt::ShiftModifier) != 0;
    const bool unused = event.acting_button == Qt::RightButton || shift_left;
    if (event.acting_button == Qt::MiddleButton || (unused && !isDragging())) {
      camera_button_ = event.acting_button;
    }
  } else if (event.type == QEvent::MouseMove && !(event.buttons_down & camera_button_)) {
    camera_button_ = Qt::NoButton;  // it was released elsewhere
  }
  const bool by_other =
      event.type != QEvent::MouseMove && event.acting_button != camera_button_ && isDragging();
  return camera_button_ != Qt::NoButton && !by_other;
}

int SurfaceTool::processMouseEvent(rviz::ViewportMouseEvent& original)
{
  int flags = 0;
  attempt([&] {
    if (!picker_) {
      return;
    }
    rviz::ViewportMouseEvent event = original;
    if (event.type == QEvent::MouseButtonDblClick) {
      event.type = QEvent::MouseButtonPress;  // the second of two quick ones
    }
    if (!movesCamera(event)) {
      flags = mouse(event);
      return;
    }
    if (event.type != QEvent::Wheel) {
      event.buttons_down &= camera_button_;  // not the one that drags something
    }
    // Shift with left is what this button does without it in RViz's other tools.
    const bool without_shift = camera_button_ == Qt::LeftButton;
    if (event.type == QEvent::MouseButtonRelease && event.acting_button == camera_button_) {
      camera_button_ = Qt::NoButton;
    }
    moveCamera(event, without_shift);
  });
  return flags;
}

void SurfaceTool::moveCamera(rviz::ViewportMouseEvent event, bool without_shift)
{
  if (without_shift) {
    event.modifiers &= ~Qt::KeyboardModifiers(Qt::ShiftModifier);
  }
  if (rviz::ViewController* view = event.panel ? event.panel->getViewController() : nullptr) {
    view->handleMouseEvent(event);
  }
}

int SurfaceTool::processKeyEvent(QKeyEvent* event, rviz::RenderPanel* /*panel*/)
{
  if (event->key() != Qt::Key_Escape) {
    return 0;
  }
  attempt([this] { end(); });
  return Render;
}

}  // namespace rviz_mesh_plugin
