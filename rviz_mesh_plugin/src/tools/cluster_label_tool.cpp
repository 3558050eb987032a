#include "tools/cluster_label_tool.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include <OgreViewport.h>
#include <rviz/display_context.h>
#include <rviz/load_resource.h>
#include <rviz/ogre_helpers/shape.h>
#include <rviz/properties/property.h>
#include <rviz/render_panel.h>
#include <rviz/tool_manager.h>
#include <rviz/view_controller.h>
#include <rviz/viewport_mouse_event.h>
#include <rviz/visualization_manager.h>
#include <QGuiApplication>
#include <QKeyEvent>
#include <QKeySequence>
#include <QString>

#include "base/grouped_number.h"
#include "displays/cluster_label_display.h"
#include "displays/display_tree.h"
#include "tools/selection/screen_outline.h"
#include "tools/selection/selection_editor.h"

namespace rviz_mesh_plugin {
namespace {

/// Of the brush's radius, per notch of the wheel.
constexpr double RADIUS_FACTOR = 1.1;

/// Brightness of the brush, so that it shows on the highlight, too.
constexpr float BALL_ADDING = 1.0f;
constexpr float BALL_REMOVING = 0.1f;
constexpr float BALL_ALPHA = 0.4f;

struct TechniqueLook
{
  const char* cursor;
  const char* hint;
};

/// Of SelectionTechnique.
constexpr TechniqueLook LOOKS[] = {
    {"package://rviz_mesh_plugin/icons/select_box.png",
     "<b>Left drag:</b> box to select. <b>Right drag:</b> to deselect. <b>Click:</b> one face."},
    {"package://rviz_mesh_plugin/icons/select_lasso.png",
     "<b>Left drag:</b> lasso to select. <b>Right drag:</b> to deselect."},
    {"package://rviz_mesh_plugin/icons/select_flood.png",
     "<b>Left click:</b> select the connected region. <b>Right click:</b> deselect it."},
    {"package://rviz_mesh_plugin/icons/select_label.png",
     "<b>Left click:</b> select the faces of a label. <b>Right click:</b> deselect them."},
};

const TechniqueLook& lookOf(SelectionTechnique technique)
{
  return LOOKS[static_cast<std::size_t>(technique)];
}

bool hasPicture(const rviz::ViewportMouseEvent& event)
{
  const Ogre::Viewport* viewport = event.viewport;
  return viewport && viewport->getCamera() && viewport->getActualWidth() > 0 &&
         viewport->getActualHeight() > 0;
}

}  // namespace

ClusterLabelTool::ClusterLabelTool()
    : properties_(getPropertyContainer(), PropertyMaker(this, [this] { onSettings(); }))
{
  shortcut_key_ = 'l';
  access_all_keys_ = true;  // else Ctrl+I would be the key of another tool
}

ClusterLabelTool::~ClusterLabelTool() = default;

/// What has been begun is given up.
void ClusterLabelTool::recover(const std::string& problem)
{
  gestures_.giveUp();
  if (outline_) {
    outline_->hide();
  }
  tell("something went wrong: " + problem);
  if (editor_) {
    editor_->giveUp();
  }
}

/// Without an editor nothing is done: that is the last that may fail.
void ClusterLabelTool::initializeTool()
{
  outline_ = std::make_unique<ScreenOutline>(scene_manager_);
  editor_ =
      std::make_unique<SelectionEditor>(context_, picker(), [this] { Q_EMIT selectionChanged(); });
  onSettings();
  // RViz updates only the tool in use, but the highlight stays with the mesh.
  if (auto* manager = dynamic_cast<rviz::VisualizationManager*>(context_)) {
    connect(manager, &rviz::VisualizationManager::preUpdate, this, &ClusterLabelTool::onFrame);
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

std::string ClusterLabelTool::selectLabels(const MeshDataConstPtr& mesh,
                                           const std::vector<LabelFacesConstPtr>& faces)
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

void ClusterLabelTool::clearSelection(const std::optional<std::uint64_t>& part_of)
{
  attempt([&] {
    if (editor_) {
      editor_->giveUp();  // also what is looked for before there is a selection
    }
    if (editor_ && mesh()) {
      editor_->change([part_of](FaceSelection& selection) -> const FaceSelection::Change& {
        const FaceSelection::Change& change = selection.clear();
        if (part_of && !change.empty()) {
          selection.joinStep(*part_of);
        }
        return change;
      });
    }
  });
  showStatus();
}

std::optional<ShownMesh> ClusterLabelTool::shownMesh() const
{
  return editor_ ? editor_->shownMesh() : std::nullopt;
}

std::vector<KnownLayer> ClusterLabelTool::layersOf(const MeshDataConstPtr& mesh) const
{
  return rviz_mesh_plugin::layersOf(context_->getRootDisplayGroup(), mesh);
}

QString ClusterLabelTool::fixedFrame() const
{
  return context_->getFixedFrame();
}

std::string ClusterLabelTool::selectBy(const MeshDataConstPtr& mesh, const FaceCriterion& criterion,
                                       Combination how)
{
  std::string reason = "the tool is not ready";
  attempt([&] {
    if (editor_) {
      message_.clear();
      reason = editor_->combine(mesh, how, [mesh, criterion](const std::atomic<bool>& cancel) {
        return facesThatMeet(criterion, *mesh, &cancel);
      });
    }
  });
  showStatus();
  return reason;
}

std::string ClusterLabelTool::undo()
{
  pressSafely(SelectionKey::UNDO);
  return message_;
}

std::string ClusterLabelTool::redo()
{
  pressSafely(SelectionKey::REDO);
  return message_;
}

void ClusterLabelTool::hide()
{
  pressSafely(SelectionKey::HIDE);
}

void ClusterLabelTool::isolate()
{
  pressSafely(SelectionKey::ISOLATE);
}

void ClusterLabelTool::showAll()
{
  pressSafely(SelectionKey::SHOW_ALL);
}

std::size_t ClusterLabelTool::hiddenCount() const
{
  return editor_ ? editor_->hiddenCount() : 0;
}

/// Whichever tool is in use.
void ClusterLabelTool::pressSafely(SelectionKey key)
{
  if (editor_) {
    attempt([this, key] { press(key); });
  }
}

void ClusterLabelTool::addHistory(const std::shared_ptr<StepHistory>& history)
{
  if (editor_) {
    editor_->addHistory(history);
  }
}

bool ClusterLabelTool::busy() const
{
  return editor_ && editor_->busy();
}

std::size_t ClusterLabelTool::waiting() const
{
  return editor_ ? editor_->waiting() : 0;
}

const SelectionVisual* ClusterLabelTool::visual() const
{
  return editor_ ? &editor_->session().visual() : nullptr;
}

/// Looks at no display: RViz also calls this while it ends, when they are gone.
void ClusterLabelTool::begin()
{
  active_ = true;
  message_.clear();
  status_.clear();
  gestures_.giveUp();
  onSettings();
}

/// Looks at no display either.
void ClusterLabelTool::end()
{
  if (editor_) {
    giveUp();
    ball_.reset();
  }
  active_ = false;
}

void ClusterLabelTool::work()
{
  if (active_ && editor_) {
    followBrushSize();
    editor_->prepare(properties_.settings());
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
    properties_.setRadius(*size);
  }
}

void ClusterLabelTool::onFrame()
{
  attempt([&] {
    const SelectionEditor::FrameResult result = editor_->frame();
    if (result.mesh_gone && gestures_.giveUp()) {
      outline_->hide();
    }
    const bool control = (QGuiApplication::keyboardModifiers() & Qt::ControlModifier) != 0;
    if (!editor_->brush() || !(control || gestures_.isDragging())) {
      ball_.reset();
    }
    if (result.text) {
      tell(*result.text);
    }
    showStatus();
  });
}

void ClusterLabelTool::onSettings()
{
  attempt([&] {
    if (editor_) {
      editor_->session().setColor(properties_.color());
      setCursor(rviz::makeIconCursor(lookOf(properties_.settings().technique).cursor));
      showStatus();
    }
  });
}

void ClusterLabelTool::giveUp()
{
  const bool dragging = gestures_.giveUp();
  outline_->hide();
  if (editor_->giveUp() || dragging) {
    tell("given up");
  }
}

int ClusterLabelTool::mouse(rviz::ViewportMouseEvent& event)
{
  if (!editor_ || !hasPicture(event)) {
    return 0;
  }
  const SelectionSettings settings = properties_.settings();
  const double area =
      static_cast<double>(event.viewport->getActualWidth()) * event.viewport->getActualHeight();
  const Gesture gesture = gestures_.handle(event, settings.technique, area);
  if (event.type == QEvent::MouseButtonPress && gestures_.isDragging()) {
    message_.clear();
  }
  switch (gesture.kind) {
    case Gesture::NOTHING:
      return 0;
    case Gesture::CAMERA: {
      ball_.reset();
      // Shift with left or right is what these buttons do without it in RViz's other tools.
      const bool middle =
          event.acting_button == Qt::MiddleButton || (event.buttons_down & Qt::MiddleButton) != 0;
      moveCamera(event, !middle && event.type != QEvent::Wheel);
      status_.clear();  // the view has its own
      return Render;
    }
    case Gesture::HOVER:
      return hover(event, gesture.brush) ? Render : 0;
    case Gesture::OUTLINE:
      ball_.reset();
      showOutline(event);
      return Render;
    case Gesture::RADIUS:
      properties_.scaleRadius(std::pow(RADIUS_FACTOR, gesture.notches));
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
  SelectionSettings settings = properties_.settings();
  settings.technique = gestures_.technique();  // as when the drag began
  std::string text;
  switch (gesture.kind) {
    case Gesture::CLICK:
      text = editor_->click(event, gesture, settings);
      break;
    case Gesture::BOX:
    case Gesture::LASSO:
      text = editor_->area(event, gesture, gestures_.path(), settings);
      break;
    default:  // of a stroke
      if (gesture.kind == Gesture::STROKE_BEGIN) {
        editor_->beginStroke();
      }
      text = editor_->stroke(event, gesture, settings);
      if (gesture.kind == Gesture::STROKE_END) {
        editor_->endStroke();
      }
      showBall(gesture.adding);
      break;
  }
  message_ = text;
  showStatus();
}

/// Returns whether there is anything new to be seen.
bool ClusterLabelTool::hover(const rviz::ViewportMouseEvent& event, bool brush)
{
  const bool was_shown = ball_ != nullptr;
  if (brush) {
    editor_->findBrush(event, properties_.settings());
    showBall(!gestures_.isDragging() || gestures_.isAdding());
  } else {
    ball_.reset();
  }
  showStatus();
  return was_shown || ball_ != nullptr;
}

/// Shows where the brush is, and how large.
void ClusterLabelTool::showBall(bool adding)
{
  const auto& hit = editor_->brush();
  if (!hit) {
    ball_.reset();
    return;
  }
  if (!ball_) {
    ball_ = std::make_unique<rviz::Shape>(rviz::Shape::Sphere, scene_manager_);
  }
  ball_->setPosition(ogreVector(pointInFixedFrame(hit->point, *hit)));
  ball_->setScale(Ogre::Vector3(static_cast<float>(2.0 * properties_.settings().radius)));
  const float light = adding ? BALL_ADDING : BALL_REMOVING;
  ball_->setColor(light, light, light, BALL_ALPHA);
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

void ClusterLabelTool::press(SelectionKey key)
{
  if (key == SelectionKey::GIVE_UP) {
    giveUp();
    return;
  }
  if (gestures_.isDragging()) {
    return;  // until the button is released
  }
  tell(change(key));
}

/// Returns what to tell the user.
std::string ClusterLabelTool::change(SelectionKey key)
{
  switch (key) {
    case SelectionKey::BOX:
    case SelectionKey::LASSO:
    case SelectionKey::FLOOD:
    case SelectionKey::LABEL:
      properties_.setTechnique(static_cast<SelectionTechnique>(
          static_cast<int>(key) - static_cast<int>(SelectionKey::BOX)));
      return message_;  // stays
    case SelectionKey::TOGGLE_VISIBLE_ONLY:
      properties_.toggleVisibleOnly();
      return properties_.settings().visible_only ? "only faces that are seen are selected"
                                                 : "faces are selected through the mesh";
    case SelectionKey::TOGGLE_BACK_FACES:
      properties_.toggleBackFaces();
      return properties_.settings().back_faces ? "faces seen from behind are selected, too"
                                               : "faces seen from behind are not selected";
    default:
      break;
  }
  switch (key) {
    case SelectionKey::UNDO:
      return editor_->undo();
    case SelectionKey::REDO:
      return editor_->redo();
    case SelectionKey::ALL:
      return editor_->selectAll();
    case SelectionKey::CLEAR:
      return editor_->change(&FaceSelection::clear);
    case SelectionKey::INVERT:
      return editor_->invert();
    case SelectionKey::GROW:
      return editor_->growOrShrink(true);
    case SelectionKey::SHRINK:
      return editor_->growOrShrink(false);
    case SelectionKey::HIDE:
      return editor_->hide();
    case SelectionKey::ISOLATE:
      return editor_->isolate();
    case SelectionKey::SHOW_ALL:
      return editor_->showAll();
    case SelectionKey::REQUEST_LABEL:
      if (busy()) {
        return STILL_LOOKING;
      }
      if (selection().empty()) {
        return "select faces first, to label them";
      }
      Q_EMIT labelRequested();
      return {};
    default:
      return {};
  }
}

void ClusterLabelTool::tell(const std::string& message)
{
  message_ = message;
  showStatus();
}

/// What the status bar says while faces are being selected, as rich text.
QString ClusterLabelTool::hint() const
{
  const SelectionSettings settings = properties_.settings();
  QString text;
  if (busy()) {
    text = settings.visible_only ? "Looking which faces are seen ... <b>Esc:</b> give up. "
                                 : "Looking for the faces ... <b>Esc:</b> give up. ";
  } else if (!message_.empty()) {
    QString message = QString::fromStdString(message_);
    message[0] = message[0].toUpper();
    text = message.toHtmlEscaped() + ". ";
  }
  const std::size_t count = selection().count();
  if (count == 0) {
    text += "No faces are selected. ";
  } else {
    const std::optional<double> area = editor_->session().area();
    text += QString(count == 1 ? "%1 face is selected, " : "%1 faces are selected, ")
                .arg(groupedNumber(count));
    text += area ? measuredNumber(*area) + " m². " : "... m². ";
    text += visual()->isCurrent() ? "" : "They are being highlighted ... ";
  }
  if (ball_) {
    return text + QString(
                      "<b>Ctrl + drag:</b> brush of %1 m, right to deselect. <b>Ctrl + "
                      "wheel:</b> its radius.")
                      .arg(settings.radius, 0, 'g', 3);
  }
  return text + lookOf(settings.technique).hint +
         " <b>Ctrl:</b> brush. <b>Shift, middle, wheel:</b> view. <b>1-4:</b> mode. <b>Enter:</b> "
         "label.";
}

/// Where another tool is in use, the status bar is that one's.
void ClusterLabelTool::showStatus()
{
  if (!active_ || !editor_) {
    return;
  }
  const QString status = hint();
  if (status != status_) {
    status_ = status;
    say(status.toStdString());
  }
}

}  // namespace rviz_mesh_plugin
