#include "tools/measuring/measurement_marks.h"

#include <algorithm>
#include <cmath>

#include <OgreCamera.h>
#include <OgreSceneManager.h>

#include "picking/view_geometry.h"
#include "rendering/text/text_layout.h"

namespace rviz_mesh_plugin {
namespace {

const Rgba8 FRAMES[] = {{255, 255, 51, 255}, {102, 217, 255, 255}, {140, 255, 140, 255}};
const Ogre::ColourValue STRAIGHT(1.0f, 1.0f, 1.0f);

/// Points have at least this diameter, in pixels.
constexpr float LEAST_PIXELS = 9.0f;

const Rgba8& colorOf(MeasurementKind kind)
{
  return FRAMES[static_cast<std::size_t>(kind)];
}

Ogre::ColourValue lineColor(MeasurementKind kind)
{
  const Rgba8& color = colorOf(kind);
  return Ogre::ColourValue(color.red / 255.0f, color.green / 255.0f, color.blue / 255.0f);
}

const ShownMesh* find(const MeshData* mesh, const std::string& display,
                      const std::vector<ShownMesh>& shown)
{
  const ShownMesh* found = nullptr;
  for (const ShownMesh& one : shown) {
    if (one.mesh.get() == mesh && (!found || one.display == display)) {
      found = &one;
    }
  }
  return found;
}

/// Sides one by one: a line that turns sharply is thin there.
void addSides(const ShownMesh& mesh, const std::vector<std::array<double, 3>>& corners, bool closed,
              const Ogre::ColourValue& color, SurfaceMarks& marks)
{
  for (std::size_t i = 0; i + (closed ? 0 : 1) < corners.size(); ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
    marks.addLine(mesh, {a[0], a[1], a[2], b[0], b[1], b[2]}, color);
  }
}

std::vector<std::array<double, 3>> positionsOf(const std::vector<SurfacePoint>& points)
{
  std::vector<std::array<double, 3>> positions;
  for (const SurfacePoint& point : points) {
    positions.push_back(point.position);
  }
  return positions;
}

std::array<double, 3> middleOf(const std::vector<SurfacePoint>& points)
{
  std::array<double, 3> sum{};
  for (const SurfacePoint& point : points) {
    for (std::size_t i = 0; i < 3; ++i) {
      sum[i] += point.position[i] / static_cast<double>(points.size());
    }
  }
  return sum;
}

std::array<double, 3> middleOf(const std::vector<double>& line)
{
  const double* const p = &line[line.size() / 3 / 2 * 3];
  return {p[0], p[1], p[2]};
}

}  // namespace

MeasurementMarks::MeasurementMarks(Ogre::SceneManager* scene_manager)
    : scene_manager_(scene_manager)
{
}

MeasurementMarks::~MeasurementMarks() = default;

std::unique_ptr<MeasurementMarks::Mark> MeasurementMarks::make(const Measurement& measurement,
                                                               const ShownMesh& mesh)
{
  auto mark = std::make_unique<Mark>();
  mark->state = measurement.state;
  mark->mesh = mesh;
  mark->marks = std::make_unique<SurfaceMarks>(scene_manager_);
  for (const SurfacePoint& point : measurement.points) {
    mark->marks->addBall(mesh, point.position);
  }
  mark->anchor = middleOf(measurement.points);
  const Ogre::ColourValue color = lineColor(measurement.kind);
  const bool area = measurement.kind == MeasurementKind::AREA;
  addSides(mesh, positionsOf(measurement.points), area, area ? color : STRAIGHT, *mark->marks);
  if (measurement.state == Measurement::DONE) {
    mark->marks->addLine(mesh, measurement.result.path.points, color);
    if (!measurement.result.path.points.empty()) {
      mark->anchor = middleOf(measurement.result.path.points);
    }
    for (const auto& piece : measurement.result.profile.pieces) {
      std::vector<double> line;
      for (const SurfaceProfile::Point& point : piece) {
        const auto position = measurement.result.profile.position(point);
        line.insert(line.end(), position.begin(), position.end());
      }
      mark->marks->addLine(mesh, line, color);
    }
  }
  mark->text = std::make_unique<SceneText>(scene_manager_->getRootSceneNode());
  mark->text->show(measurement.lines(), colorOf(measurement.kind));
  return mark;
}

void MeasurementMarks::place(Mark& mark, const std::vector<ShownMesh>& shown,
                             const Ogre::Camera* camera, float size)
{
  mark.marks->follow(shown);
  const ShownMesh* const mesh = find(mark.mesh.mesh.get(), mark.mesh.display, shown);
  if (!mesh) {
    return;
  }
  const Ogre::Vector3 anchor = ogreVector(pointInFixedFrame(mark.anchor, *mesh));
  const auto seen = placeInPicture(anchor, camera);
  size = std::max(size, LEAST_PIXELS * (seen ? seen->meters : 0.0f));
  // Lines are made anew with another width: not for what nobody sees.
  if (std::abs(size - mark.size) > 0.1f * mark.size) {
    mark.size = size;
    mark.marks->setSize(size);
  }
  mark.position = anchor;
}

void MeasurementMarks::show(const std::vector<Measurement>& measurements,
                            const std::vector<ShownMesh>& shown, const Ogre::Camera* camera,
                            float size, bool values)
{
  std::map<std::uint32_t, std::unique_ptr<Mark>> kept;
  TextLayout layout(camera);
  for (const Measurement& measurement : measurements) {
    const MeshDataConstPtr mesh = measurement.mesh.lock();
    const ShownMesh* const place_of =
        mesh && !measurement.stale ? find(mesh.get(), measurement.display, shown) : nullptr;
    if (!place_of) {
      continue;
    }
    std::unique_ptr<Mark>& mark = marks_[measurement.number];
    if (!mark || mark->state != measurement.state || mark->mesh.mesh != mesh) {
      mark = make(measurement, *place_of);
    }
    mark->text->setVisible(values);
    place(*mark, shown, camera, size);
    mark->text->setPosition(mark->position);
    // Where no place is free it covers others: each value can be read in the list.
    const auto offset = layout.add(mark->position, mark->text->width(), mark->text->height());
    mark->text->setOffset(offset ? offset->first : 0, offset ? offset->second : 0);
    kept[measurement.number] = std::move(mark);
  }
  marks_ = std::move(kept);
  if (begun_) {
    place(*begun_, shown, camera, size);
  }
}

void MeasurementMarks::showPoints(const ShownMesh& mesh, const std::vector<SurfacePoint>& points,
                                  const std::array<double, 3>* next)
{
  const float size = begun_ ? begun_->size : 0.1f;
  begun_ = std::make_unique<Mark>();
  begun_->mesh = mesh;
  begun_->marks = std::make_unique<SurfaceMarks>(scene_manager_);
  begun_->size = size;
  begun_->marks->setSize(size);
  begun_->anchor = points.back().position;
  for (const SurfacePoint& point : points) {
    begun_->marks->addBall(mesh, point.position);
  }
  auto corners = positionsOf(points);
  if (next) {
    corners.push_back(*next);
  }
  addSides(mesh, corners, false, STRAIGHT, *begun_->marks);
}

void MeasurementMarks::clearPoints()
{
  begun_.reset();
}

}  // namespace rviz_mesh_plugin
