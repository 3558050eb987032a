#include "tools/mesh_inspect_tool.h"

#include <algorithm>

#include <geometry_msgs/PointStamped.h>
#include <ros/time.h>
#include <rviz/display_context.h>
#include <rviz/viewport_mouse_event.h>

#include "base/vectors.h"
#include "displays/display_tree.h"
#include "displays/textured_mesh_display.h"
#include "picking/label_lookup.h"
#include "picking/point_values.h"
#include "picking/view_geometry.h"
#include "properties/property_maker.h"
#include "tools/measuring/surface_marks.h"

namespace rviz_mesh_plugin {
namespace {

/// Points are looked up at most 30 times a second.
constexpr std::chrono::milliseconds HOVER_EVERY(33);

std::string meters(double length)
{
  return QString::number(length, 'f', 3).toStdString() + " m";
}

/// Two displays may show the same mesh in two places.
bool isSame(const ShownMesh& a, const ShownMesh& b)
{
  return a.mesh == b.mesh && a.display == b.display;
}

/// The first display that has a layer gives its value.
void addLayer(const PointReport::Layer& layer, PointReport& report)
{
  const auto found = std::find_if(report.layers.begin(), report.layers.end(),
                                  [&](const auto& other) { return other.name == layer.name; });
  if (found == report.layers.end()) {
    report.layers.push_back(layer);
  } else if (found->value.kind == PointValue::NOT_LOADED) {
    *found = layer;
  }
}

void add(const TexturedMeshDisplay& display, const SurfaceHit& hit, PointReport& report)
{
  if (!display.has(hit.mesh)) {
    return;
  }
  const MeshAttributes& attributes = display.attributes(*hit.mesh);
  addLabelsAt(attributes.labels, hit.face, report.labels);
  for (const std::string& name : display.costTypes()) {
    const CostLayerConstPtr layer = attributes.cost(name);
    const LayerInfo& info = display.layerInfo(*hit.mesh, name);
    addLayer({name, valueAt(layer.get(), *hit.mesh, hit.face, hit.barycentric), info,
              isLethalAt(layer.get(), info, *hit.mesh, hit.face, hit.barycentric)},
             report);
  }
}

/// What the displays that are enabled know of a point: layers and labels of all that show its mesh.
PointReport reportAt(const SurfaceHit& hit, rviz::DisplayContext& context)
{
  PointReport report;
  report.face = hit.face;
  report.vertex = nearestCorner(*hit.mesh, hit.face, hit.point);
  report.in_mesh = {hit.source.frame.empty() ? hit.mesh->frame_id : hit.source.frame, hit.point};
  report.in_fixed_frame = {context.getFixedFrame().toStdString(),
                           pointInFixedFrame(hit.point, hit)};
  const rviz::DisplayGroup* root = context.getRootDisplayGroup();
  visitDisplays<TexturedMeshDisplay>(
      root, DisplayChoice::ENABLED,
      [&](const TexturedMeshDisplay& display) { add(display, hit, report); });
  for (const LabelClusterConstPtr& label : labelsAt(root, *hit.mesh, hit.face)) {
    report.labels.insert(label->label);
  }
  return report;
}

}  // namespace

MeshInspectTool::MeshInspectTool()
    : topic_(getPropertyContainer(), "clicked_point",
             "The topic on which to publish points that are clicked at.",
             PublishedTopic::advertise<geometry_msgs::PointStamped>)
{
  shortcut_key_ = 'q';
  const PropertyMaker make(this, [this] { attempt([this] { showSize(); }); });
  size_ = make.number("Marker Size", 0.1f, "The diameter of the balls that mark points, in meters.",
                      getPropertyContainer(), 0.001f);
}

MeshInspectTool::~MeshInspectTool() = default;

void MeshInspectTool::initializeTool()
{
  topic_.connect();
  marks_ = std::make_unique<SurfaceMarks>(scene_manager_);
  showSize();
}

void MeshInspectTool::showSize()
{
  if (marks_) {
    marks_->setSize(size_->getFloat());
    context_->queueRender();
  }
}

void MeshInspectTool::begin()
{
  clearMarks();
  pointed_ =
      "Point at a mesh to see its values. Left button: publish the point; a second one measures "
      "the distance; Esc: remove the markers. Right, middle and Shift + left button and wheel move "
      "the "
      "camera.";
  tell();
}

void MeshInspectTool::end()
{
  next_hover_.reset();
  pointed_.clear();
  clearMarks();
}

void MeshInspectTool::clearMarks()
{
  measurement_.drop();
  first_.reset();
  second_.reset();
  clicked_.clear();
  if (marks_) {
    marks_->clear();
    context_->queueRender();
  }
}

void MeshInspectTool::tell()
{
  say(clicked_ + (clicked_.empty() || pointed_.empty() ? "" : " · ") + pointed_);
}

void MeshInspectTool::work()
{
  if ((first_ && !picker().exists(first_->mesh)) || (second_ && !picker().exists(second_->mesh))) {
    clearMarks();
    pointed_ = "The mesh of the markers is gone, and they with it: click anew.";
    tell();
  }
  if (first_) {
    marks_->follow(picker().meshes());
  }
  takeResult();
  if (next_hover_ && Clock::now() - last_hover_ >= HOVER_EVERY) {
    const mesh_map::Ray ray = *next_hover_;
    hover(ray);
  }
}

int MeshInspectTool::mouse(rviz::ViewportMouseEvent& event)
{
  if (event.leftDown()) {
    const Pick pick = picker().pick(event);
    if (pick.hit) {
      click(*pick.hit);
    } else {
      pointed_ = "Nothing can be marked: " + pick.reason;
    }
    tell();
    return Render;
  }
  if (event.type == QEvent::MouseMove) {
    next_hover_ = cursorRay(event);
    if (Clock::now() - last_hover_ >= HOVER_EVERY) {
      hover(cursorRay(event));
    }
  }
  return 0;
}

void MeshInspectTool::hover(const mesh_map::Ray& ray)
{
  last_hover_ = Clock::now();
  next_hover_.reset();
  const Pick pick = picker().pick(ray);
  pointed_ = pick.hit ? textOf(reportAt(*pick.hit, *context_)) : pick.reason;
  tell();
}

void MeshInspectTool::click(const SurfaceHit& hit)
{
  if (second_) {
    clearMarks();
  }
  pointed_ = publish(hit) + " · " + textOf(reportAt(hit, *context_));
  marks_->addBall(hit, hit.point);
  if (first_) {
    second_ = hit;
    measure(hit);
  } else {
    first_ = hit;
    clicked_ = "Click at a second point to measure the distance";
  }
}

std::string MeshInspectTool::publish(const SurfaceHit& hit)
{
  const auto point = pointInFixedFrame(hit.point, hit);
  geometry_msgs::PointStamped message;
  message.header.frame_id = context_->getFixedFrame().toStdString();
  message.header.stamp = ros::Time::now();
  message.point.x = point[0];
  message.point.y = point[1];
  message.point.z = point[2];
  return topic_.publish("The point", message);
}

void MeshInspectTool::measure(const SurfaceHit& hit)
{
  if (isSame(*first_, hit)) {
    const SurfacePoint from = {first_->face, first_->point};
    const SurfacePoint to = {hit.face, hit.point};
    measurement_.start([mesh = hit.mesh, from, to](const Cancellation& cancellation) {
      return findPath(*mesh, from, to, &cancellation.flag());
    });
    clicked_ = "Measuring the way along the surface…";
  } else {
    const double length =
        distance(pointInFixedFrame(first_->point, *first_), pointInFixedFrame(hit.point, hit));
    clicked_ =
        "The points are on different meshes, " + meters(length) + " apart in a straight line";
  }
}

void MeshInspectTool::takeResult()
{
  const auto outcome = measurement_.take();
  if (!outcome || !second_) {
    return;
  }
  const std::string apart = meters(distance(first_->point, second_->point)) + " in a straight line";
  if (!outcome->result) {
    clicked_ = "The way could not be measured: " + outcome->error + "; " + apart;
  } else if (!outcome->result->connected) {
    clicked_ = "The points are not connected along the surface; " + apart;
  } else {
    clicked_ = "Distance " + meters(outcome->result->length) + " along the surface, " + apart;
    marks_->addLine(*second_, outcome->result->points);
  }
  context_->queueRender();
  tell();
}

}  // namespace rviz_mesh_plugin
