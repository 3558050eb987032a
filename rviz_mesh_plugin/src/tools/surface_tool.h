#pragma once

#include <functional>
#include <memory>
#include <string>

#include <rviz/tool.h>

#include "picking/surface_picker.h"

class QKeyEvent;

namespace rviz_mesh_plugin {

/// What tools that point at surfaces have in common: a picker, a camera that can be moved (where
/// they do not say otherwise, with the wheel, the middle and right buttons, and Shift and the left
/// one); and nothing is thrown to RViz.
class SurfaceTool : public rviz::Tool
{
 public:
  void activate() final;
  void deactivate() final;
  void update(float wall_dt, float ros_dt) final;
  int processMouseEvent(rviz::ViewportMouseEvent& event) final;
  int processKeyEvent(QKeyEvent* event, rviz::RenderPanel* panel) override;

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
  /// Whether it is the camera's, and not for mouse().
  virtual bool movesCamera(const rviz::ViewportMouseEvent& event);
  /// After something went wrong: says so.
  virtual void recover(const std::string& problem);

  const SurfacePicker& picker() const { return *picker_; }
  /// In the status bar. While the tool is in use it stays there, though RViz clears that whenever
  /// the mouse leaves the picture or the window.
  void say(const std::string& text);
  /// Hands an event to the view. @param without_shift as if that key was not down
  static void moveCamera(rviz::ViewportMouseEvent event, bool without_shift);

  /// Does it; errors end here, and lead to recover().
  void attempt(const std::function<void()>& work);

 private:
  void sayAgain();

  std::unique_ptr<SurfacePicker> picker_;
  bool in_use_ = false;
  std::string said_;
  Qt::MouseButton camera_button_ = Qt::NoButton;  ///< by which the camera is being moved
};

}  // namespace rviz_mesh_plugin
