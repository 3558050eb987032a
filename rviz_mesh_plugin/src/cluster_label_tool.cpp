#include "rviz_mesh_plugin/cluster_label_tool.h"

#include <exception>

#include <OgreViewport.h>
#include <ros/console.h>
#include <rviz/display_context.h>
#include <rviz/load_resource.h>
#include <rviz/properties/property.h>
#include <rviz/visualization_manager.h>
#include <QGuiApplication>

#include "display_tree.h"
#include "rviz_mesh_plugin/brush_ball.h"
#include "rviz_mesh_plugin/cluster_label_display.h"
#include "rviz_mesh_plugin/screen_outline.h"
#include "rviz_mesh_plugin/selection_editor.h"
#include "rviz_mesh_plugin/selection_hints.h"

namespace rviz_mesh_plugin {
namespace {

/// Seconds between two lines of the log.
constexpr double LOG_PERIOD = 5.0;

const char* cursorOf(SelectionTechnique technique)
{
  switch (technique) {
    case SelectionTechnique::LASSO:
      return "package://rviz_mesh_plugin/icons/select_lasso.png";
    case SelectionTechnique::FLOOD:
      return "package://rviz_mesh_plugin/icons/select_flood.png";
    case SelectionTechnique::LABEL:
      return "package://rviz_mesh_plugin/icons/select_label.png";
    default:
      return "package://rviz_mesh_plugin/icons/select_box.png";
  }
}

}  // namespace

ClusterLabelTool::ClusterLabelTool()
    : properties_(new SelectionProperties(getPropertyContainer(), this))
{
  shortcut_key_ = 'l';
  access_all_keys_ = true;  // else Ctrl+I would be the key of another tool
  connect(properties_, &SelectionProperties::changed, this, &ClusterLabelTool::onSettings);
}

ClusterLabelTool::~ClusterLabelTool() = default;

/// Errors end here; what has been begun is given up then.
bool ClusterLabelTool::attempt(const std::function<void()>& work)
{
  try {
    try {
      work();
      return true;
    } catch (const std::exception& error) {
      ROS_ERROR_THROTTLE(LOG_PERIOD, "Cluster Label: %s", error.what());
      gestures_.giveUp();
      if (outline_) {
        outline_->hide();
      }
      say(std::string("something went wrong: ") + error.what());
      if (editor_) {
        editor_->giveUp();
      }
    }
  } catch (const std::exception&) {  // no memory to say so
  }
  return false;
}

void ClusterLabelTool::onInitialize()
{
  const bool ready = attempt([&] {
    editor_ = std::make_unique<SelectionEditor>(context_, [this] { Q_EMIT selectionChanged(); });
    outline_ = std::make_unique<ScreenOutline>(scene_manager_);
    ball_ = std::make_unique<BrushBall>(scene_manager_);
    onSettings();
    // RViz updates only the tool in use, but the highlight stays with the mesh.
    if (auto* manager = dynamic_cast<rviz::VisualizationManager*>(context_)) {
      connect(manager, &rviz::VisualizationManager::preUpdate, this, &ClusterLabelTool::onFrame);
    }
  });
  if (!ready) {
    editor_.reset();  // then nothing is done
  }
}

MeshDataConstPtr ClusterLabelTool::mesh() const
{
  return editor_ ? editor_->session().mesh() : nullptr;
}

const FaceSelection& ClusterLabelTool::selection() const
{
  static const FaceSelection NONE;
  return editor_ ? editor_->session().selection() : NONE;
}

std::string ClusterLabelTool::select(const MeshDataConstPtr& mesh,
                                     const FaceSelection::Faces& faces)
{
  std::string reason = "the tool is not ready";
  attempt([&] {
    if (editor_) {
      gestures_.giveUp();
      outline_->hide();
      reason = editor_->replace(mesh, faces);
    }
  });
  showStatus();
  return reason;
}

void ClusterLabelTool::clearSelection()
{
  attempt([&] {
    if (editor_ && mesh()) {
      editor_->giveUp();
      editor_->change([](FaceSelection& selection) -> const FaceSelection::Change& {
        return selection.clear();
      });
    }
  });
  showStatus();
}

bool ClusterLabelTool::busy() const
{
  return editor_ && editor_->busy();
}

const SelectionVisual* ClusterLabelTool::visual() const
{
  return editor_ ? &editor_->session().visual() : nullptr;
}

/// Looks at no display: RViz also calls this while it ends, when they are gone.
void ClusterLabelTool::activate()
{
  attempt([&] {
    active_ = true;
    message_.clear();
    status_.clear();
    gestures_.giveUp();
    onSettings();
  });
}

/// Also what Esc leads to, in RViz; looks at no display either.
void ClusterLabelTool::deactivate()
{
  attempt([&] {
    if (editor_) {
      giveUp();
      ball_->hide();
    }
    active_ = false;
  });
}

void ClusterLabelTool::update(float /*wall_dt*/, float /*ros_dt*/)
{
  if (active_ && editor_) {
    attempt([&] {
      followBrushSize();
      editor_->prepare(properties_->settings());
    });
  }
}

/// Displays have a property for the brush, too, which files in the field set.
void ClusterLabelTool::followBrushSize()
{
  std::optional<float> size;
  visitDisplays<ClusterLabelDisplay>(
      context_->getRootDisplayGroup(), DisplayChoice::ENABLED,
      [&](const ClusterLabelDisplay& display) { size = size ? size : display.brushSize(); });
  if (size && *size != brush_size_) {
    brush_size_ = *size;
    properties_->setRadius(*size);
  }
}

void ClusterLabelTool::onFrame()
{
  attempt([&] {
    const SelectionEditor::News news = editor_->frame();
    if (news.mesh_gone && gestures_.giveUp()) {
      outline_->hide();
    }
    const bool control = (QGuiApplication::keyboardModifiers() & Qt::ControlModifier) != 0;
    if (!editor_->brush() || !(control || gestures_.isDragging())) {
      ball_->hide();
    }
    if (!news.text.empty()) {
      say(news.text);
    }
    showStatus();
  });
}

void ClusterLabelTool::onSettings()
{
  attempt([&] {
    if (editor_) {
      editor_->session().setColor(properties_->color());
      setCursor(rviz::makeIconCursor(cursorOf(properties_->settings().technique)));
      showStatus();
    }
  });
}

void ClusterLabelTool::giveUp()
{
  const bool dragging = gestures_.giveUp();
  outline_->hide();
  if (editor_->giveUp() || dragging) {
    say("given up");
  }
}

void ClusterLabelTool::say(const std::string& message)
{
  message_ = message;
  showStatus();
}

/// Where another tool is in use, the status bar is that one's.
void ClusterLabelTool::showStatus()
{
  if (!active_ || !editor_) {
    return;
  }
  SelectionState state;
  state.count = selection().count();
  state.area = editor_->session().area();
  state.busy = busy();
  state.brush = ball_ && ball_->isShown();
  state.message = message_;
  const QString status = selectionHint(state, properties_->settings());
  if (status != status_) {
    status_ = status;
    setStatus(status);
  }
}

}  // namespace rviz_mesh_plugin
