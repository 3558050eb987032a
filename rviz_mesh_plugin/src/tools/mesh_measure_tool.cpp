#include "tools/mesh_measure_tool.h"

#include <cmath>

#include <OgreCamera.h>
#include <OgreViewport.h>
#include <QKeyEvent>

#include <rviz/display_context.h>
#include <rviz/panel_dock_widget.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/viewport_mouse_event.h>
#include <rviz/visualization_manager.h>
#include <rviz/window_manager_interface.h>

#include "picking/view_geometry.h"
#include "properties/property_maker.h"
#include "tools/measuring/measurement_marks.h"
#include "tools/measuring/measurement_pane.h"

namespace rviz_mesh_plugin {
namespace {

/// The line to the cursor follows it at most 30 times a second.
constexpr std::chrono::milliseconds FOLLOW_EVERY(33);

/// A click so near to a point, in pixels, is one at it.
constexpr double NEAR = 8.0;

}  // namespace

MeshMeasureTool::MeshMeasureTool() : list_([this] { attempt([this] { listChanged(); }); })
{
  shortcut_key_ = 'd';
  rviz::Property* const parent = getPropertyContainer();
  const PropertyMaker kind_maker(this, [this] { attempt([this] { changeKind(); }); });
  kind_ = kind_maker.choice("Measure", "Distance", "What clicks measure.", parent,
                            {"Distance", "Area", "Profile"});
  const PropertyMaker make(this, [this] {
    if (context_) {
      context_->queueRender();
    }
  });
  size_ = make.number("Marker Size", 0.1f,
                      "The diameter of points, in meters; never less than a few pixels.", parent,
                      0.001f);
  values_ = make.box("Show Values", true, "Whether values stand beside what is measured.", parent);
}

MeshMeasureTool::~MeshMeasureTool()
{
  delete pane_;
  delete dock_;
}

MeasurementPane* MeshMeasureTool::pane() const
{
  return pane_;
}

void MeshMeasureTool::initializeTool()
{
  marks_ = std::make_unique<MeasurementMarks>(scene_manager_);
  // What is measured stays while other tools are in use.
  if (auto* manager = dynamic_cast<rviz::VisualizationManager*>(context_)) {
    connect(manager, &rviz::VisualizationManager::preUpdate, this,
            [this] { attempt([this] { keepUp(); }); });
  }
}

void MeshMeasureTool::createPane()
{
  if (!pane_) {
    pane_ = new MeasurementPane(list_,
                                [this](MeasurementKind kind) { attempt([&] { choose(kind); }); });
    connect(pane_.data(), &MeasurementPane::removeAsked, this, [this](const auto& numbers) {
      for (const std::uint32_t number : numbers) {
        attempt([&] { list_.remove(number); });
      }
    });
    connect(pane_.data(), &MeasurementPane::clearAsked, this,
            [this] { attempt([this] { list_.clear(); }); });
    pane_->showKind(kind());
    if (auto* window = context_->getWindowManager()) {
      dock_ = window->addPane("Measurements", pane_, Qt::RightDockWidgetArea);
    }
  }
  if (dock_) {
    dock_->show();
  }
}

void MeshMeasureTool::begin()
{
  active_ = true;
  createPane();
  say(hint());
}

void MeshMeasureTool::end()
{
  active_ = false;
  giveUp();
}

MeasurementKind MeshMeasureTool::kind() const
{
  return static_cast<MeasurementKind>(std::max(0, kind_->getOptionInt()));
}

void MeshMeasureTool::choose(MeasurementKind kind)
{
  kind_->setString(nameOf(kind));
}

void MeshMeasureTool::changeKind()
{
  giveUp();
  if (pane_) {
    pane_->showKind(kind());
  }
  if (active_) {
    say(hint());
  }
}

std::string MeshMeasureTool::hint() const
{
  const std::string count = std::to_string(points_.size());
  switch (kind()) {
    case MeasurementKind::AREA:
      return points_.empty()
                 ? "Click at the corners of an area. Right, middle and Shift + left "
                   "button and wheel move the camera."
                 : count + (points_.size() == 1 ? " corner: " : " corners: ") +
                       "click at the next one; Enter, a double click or a click at the "
                       "first one closes the outline; Backspace takes the last one back";
    case MeasurementKind::PROFILE:
      return points_.empty() ? "Click at the begin of a height profile, then at its end."
                             : "Click at the end of the profile; Backspace takes its begin back";
    default:
      return points_.empty() ? "Click at two points to measure the distance between them."
                             : "Click at the second point; Backspace takes the first one back";
  }
}

void MeshMeasureTool::giveUp()
{
  points_.clear();
  mesh_.reset();
  next_hover_.reset();
  if (marks_) {
    marks_->clearPoints();
    context_->queueRender();
  }
}

void MeshMeasureTool::keepUp()
{
  list_.work([this](const std::string& uuid) { return picker().search(uuid).meshes; });
  if (pane_) {
    pane_->work();
  }
  if (mesh_ && !picker().exists(mesh_->mesh)) {
    giveUp();
    say("The mesh of the points is gone, and they with it: click anew.");
  }
  const rviz::ViewController* view =
      context_->getViewManager() ? context_->getViewManager()->getCurrent() : nullptr;
  marks_->show(list_.all(), picker().meshes(), view ? view->getCamera() : nullptr,
               size_->getFloat(), values_->getBool());
}

void MeshMeasureTool::work()
{
  if (next_hover_ && Clock::now() - last_hover_ >= FOLLOW_EVERY) {
    const mesh_map::Ray ray = *next_hover_;
    hover(ray);
  }
}

int MeshMeasureTool::mouse(rviz::ViewportMouseEvent& event)
{
  if (event.leftDown()) {
    const Pick pick = picker().pick(event);
    if (pick.hit) {
      click(event, *pick.hit);
    } else {
      say("Nothing can be measured here: " + pick.reason);
    }
    return Render;
  }
  if (event.type == QEvent::MouseMove && !points_.empty()) {
    next_hover_ = cursorRay(event);
    if (Clock::now() - last_hover_ >= FOLLOW_EVERY) {
      hover(cursorRay(event));
    }
  }
  return 0;
}

void MeshMeasureTool::hover(const mesh_map::Ray& ray)
{
  last_hover_ = Clock::now();
  next_hover_.reset();
  if (points_.empty()) {
    return;
  }
  const Pick pick = picker().pick(ray);
  const bool same = pick.hit && pick.hit->mesh == mesh_->mesh;
  showBegun(same ? &pick.hit->point : nullptr);
}

void MeshMeasureTool::showBegun(const std::array<double, 3>* next)
{
  if (points_.empty()) {
    marks_->clearPoints();
  } else {
    marks_->showPoints(*mesh_, points_, next);
  }
  context_->queueRender();
}

bool MeshMeasureTool::isNear(const rviz::ViewportMouseEvent& event, const SurfacePoint& point) const
{
  const Ogre::Viewport* const viewport = event.viewport;
  if (!viewport || !viewport->getCamera()) {
    return false;
  }
  const auto m = meshToClip(*viewport->getCamera(), *mesh_);
  std::array<double, 4> clip{};
  for (std::size_t row = 0; row < 4; ++row) {
    clip[row] = m[4 * row] * point.position[0] + m[4 * row + 1] * point.position[1] +
                m[4 * row + 2] * point.position[2] + m[4 * row + 3];
  }
  if (clip[3] <= 0.0) {
    return false;
  }
  const double x = (0.5 + 0.5 * clip[0] / clip[3]) * viewport->getActualWidth();
  const double y = (0.5 - 0.5 * clip[1] / clip[3]) * viewport->getActualHeight();
  return std::hypot(x - event.x, y - event.y) <= NEAR;
}

void MeshMeasureTool::click(const rviz::ViewportMouseEvent& event, const SurfaceHit& hit)
{
  const bool area = kind() == MeasurementKind::AREA;
  if (!points_.empty() && isNear(event, points_.back())) {
    if (area && points_.size() >= 3) {
      finish();  // a double click
    }
    return;  // what was clicked at twice is one point
  }
  if (area && points_.size() >= 3 && isNear(event, points_.front())) {
    finish();
    return;
  }
  if (!points_.empty() && (hit.mesh != mesh_->mesh || hit.display != mesh_->display)) {
    say("All points of a measurement are on one mesh: this one is on that of '" + hit.display +
        "', the others on that of '" + mesh_->display + "'");
    return;
  }
  addPoint(hit);
}

void MeshMeasureTool::addPoint(const SurfaceHit& hit)
{
  if (points_.empty()) {
    mesh_ = static_cast<const ShownMesh&>(hit);
  }
  points_.push_back({hit.face, hit.point});
  if (kind() != MeasurementKind::AREA && points_.size() == 2) {
    finish();
  } else {
    showBegun(nullptr);
    say(hint());
  }
}

void MeshMeasureTool::finish()
{
  const MeasurementKind what = kind();
  const std::size_t least = what == MeasurementKind::AREA ? 3 : 2;
  if (points_.size() < least) {
    say(what == MeasurementKind::AREA ? "An area has three corners at least: click at more"
                                      : hint());
    return;
  }
  const std::string frame =
      mesh_->source.frame.empty() ? mesh_->mesh->frame_id : mesh_->source.frame;
  list_.add(what, mesh_->mesh, frame, mesh_->display, points_);
  giveUp();
}

void MeshMeasureTool::takeBack()
{
  if (!points_.empty()) {
    points_.pop_back();
    showBegun(nullptr);
    if (points_.empty()) {
      giveUp();
    }
  }
  say(hint());
}

/// Of the newest one.
void MeshMeasureTool::listChanged()
{
  if (pane_) {
    pane_->refresh();
  }
  if (active_ && !list_.all().empty() && points_.empty()) {
    const Measurement& newest = list_.all().back();
    if (newest.state != Measurement::WAITING || newest.kind == MeasurementKind::DISTANCE) {
      say(std::string(nameOf(newest.kind)) + " " + std::to_string(newest.number) + ": " +
          newest.value() + (newest.value().empty() ? "" : ", ") + newest.details());
    }
  }
  if (context_) {
    context_->queueRender();
  }
}

int MeshMeasureTool::processKeyEvent(QKeyEvent* event, rviz::RenderPanel* panel)
{
  if (event->type() != QEvent::KeyPress) {
    return 0;
  }
  if (event->key() == Qt::Key_Return || event->key() == Qt::Key_Enter) {
    attempt([this] { finish(); });
    return Render;
  }
  if (event->key() == Qt::Key_Backspace) {
    attempt([this] { takeBack(); });
    return Render;
  }
  return SurfaceTool::processKeyEvent(event, panel);
}

}  // namespace rviz_mesh_plugin
