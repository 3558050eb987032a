#include "tools/measuring/surface_marks.h"

#include <algorithm>
#include <utility>

#include <OgreMaterial.h>
#include <OgreMovableObject.h>
#include <OgreRenderQueue.h>
#include <OgreSceneNode.h>
#include <rviz/ogre_helpers/billboard_line.h>
#include <rviz/ogre_helpers/shape.h>

#include "picking/view_geometry.h"

namespace rviz_mesh_plugin {
namespace {

/// So that RViz's chains, which share one buffer, hold any number of points.
constexpr std::size_t POINTS_PER_LINE = 1000;

/// Of the size of balls.
constexpr float LINE_WIDTH = 0.3f;

/// After labels and what is selected.
constexpr Ogre::uint8 AFTER_SURFACES = Ogre::RENDER_QUEUE_MAIN + 3;

const Ogre::ColourValue BALL_COLOR(1.0f, 0.75f, 0.0f);

/// The mesh as it is shown now, by the same display where it still has its name; else null.
const ShownMesh* find(const ShownMesh& mesh, const std::vector<ShownMesh>& shown)
{
  const ShownMesh* found = nullptr;
  for (const ShownMesh& one : shown) {
    if (one.mesh == mesh.mesh && (!found || one.display == mesh.display)) {
      found = &one;
    }
  }
  return found;
}

}  // namespace

const Ogre::ColourValue SurfaceMarks::LINE_COLOR(1.0f, 1.0f, 0.2f);

SurfaceMarks::SurfaceMarks(Ogre::SceneManager* scene_manager) : scene_manager_(scene_manager) {}

SurfaceMarks::~SurfaceMarks() = default;

void SurfaceMarks::addBall(const ShownMesh& mesh, const std::array<double, 3>& point)
{
  Ball ball{mesh, point, nullptr};
  ball.shape = std::make_unique<rviz::Shape>(rviz::Shape::Sphere, scene_manager_);
  ball.shape->setColor(BALL_COLOR);
  ball.shape->setScale(Ogre::Vector3(size_));
  ball.shape->setPosition(ogreVector(pointInFixedFrame(point, mesh)));
  balls_.push_back(std::move(ball));
}

void SurfaceMarks::clear()
{
  balls_.clear();
  lines_.clear();
}

void SurfaceMarks::setSize(float size)
{
  size_ = size;
  for (Ball& ball : balls_) {
    ball.shape->setScale(Ogre::Vector3(size_));
  }
  for (Line& line : lines_) {
    line.line->setLineWidth(LINE_WIDTH * size_);
  }
}

/// Relative to the first point, so that floats are exact far from the origin as well.
void SurfaceMarks::addLine(const ShownMesh& mesh, const std::vector<double>& points,
                           const Ogre::ColourValue& color)
{
  const std::size_t count = points.size() / 3;
  if (count < 2) {
    return;
  }
  auto line = std::make_unique<rviz::BillboardLine>(scene_manager_);
  const std::size_t steps = POINTS_PER_LINE - 1;
  line->setMaxPointsPerLine(static_cast<std::uint32_t>(std::min(count, POINTS_PER_LINE)));
  line->setNumLines(static_cast<std::uint32_t>((count - 1 + steps - 1) / steps));
  line->setLineWidth(LINE_WIDTH * size_);
  line->setColor(color.r, color.g, color.b, 1.0f);
  const double* const origin = points.data();
  for (std::size_t i = 0; i < count; ++i) {
    const double* const p = &points[3 * i];
    const Ogre::Vector3 point = ogreVector({p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]});
    line->addPoint(point);
    if (i % steps == 0 && i > 0 && i + 1 < count) {
      line->newLine();
      line->addPoint(point);
    }
  }
  line->getMaterial()->setDepthCheckEnabled(false);
  Ogre::SceneNode* const node = line->getSceneNode();
  for (unsigned short i = 0; i < node->numAttachedObjects(); ++i) {
    node->getAttachedObject(i)->setRenderQueueGroup(AFTER_SURFACES);
  }
  lines_.push_back({mesh, {origin[0], origin[1], origin[2]}, std::move(line)});
  place(lines_.back(), mesh);
}

void SurfaceMarks::place(const Line& line, const ShownMesh& mesh)
{
  line.line->setPosition(ogreVector(pointInFixedFrame(line.origin, mesh)));
  line.line->setOrientation(mesh.orientation);
}

void SurfaceMarks::follow(const std::vector<ShownMesh>& shown)
{
  for (Ball& ball : balls_) {
    const ShownMesh* const mesh = find(ball.mesh, shown);
    ball.shape->getRootNode()->setVisible(mesh != nullptr);
    if (mesh) {
      ball.shape->setPosition(ogreVector(pointInFixedFrame(ball.point, *mesh)));
    }
  }
  for (Line& line : lines_) {
    const ShownMesh* const mesh = find(line.mesh, shown);
    line.line->getSceneNode()->setVisible(mesh != nullptr);
    if (mesh) {
      place(line, *mesh);
    }
  }
}

}  // namespace rviz_mesh_plugin
