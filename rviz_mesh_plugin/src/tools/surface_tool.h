#pragma once

#include <functional>
#include <memory>
#include <string>

#ifndef Q_MOC_RUN
#include <rviz/tool.h>

#include "picking/surface_picker.h"
#endif

class QKeyEvent;

namespace rviz_mesh_plugin {

/// What tools that point at surfaces have in common: a picker, a camera that can be moved with the
/// wheel, the middle and right buttons, and Shift and the left one; and nothing is thrown to RViz.
class SurfaceTool : public rviz::Tool
{
  Q_OBJECT

 public:
  void activate() final;
  void deactivate() final;
  void update(float wall_dt, float ros_dt) final;
  int processMouseEvent(rviz::ViewportMouseEvent& event) final;
  int processKeyEvent(QKeyEvent* event, rviz::RenderPanel* panel) final;

 protected:
  void onInitialize() final;

  /// Do what the functions of rviz::Tool do; what they throw becomes a status text.
  virtual void initializeTool() = 0;
  virtual void begin() = 0;
  virtual void end() = 0;  ///< also after Esc, by which RViz leaves a tool
  virtual void work() {}   ///< each frame while the tool is active
  virtual int mouse(rviz::ViewportMouseEvent& event) = 0;
  /// Whether the left button is in use, and the right one is not for the camera.
  virtual bool isDragging() const { return false; }

  const SurfacePicker& picker() const { return *picker_; }
  void say(const std::string& text);

  /// Does it, and says what went wrong.
  void attempt(const std::function<void()>& work);

 private:
  bool movesCamera(const rviz::ViewportMouseEvent& event);

  std::unique_ptr<SurfacePicker> picker_;
  Qt::MouseButton camera_button_ = Qt::NoButton;  ///< by which the camera is being moved
};

}  // namespace rviz_mesh_plugin
