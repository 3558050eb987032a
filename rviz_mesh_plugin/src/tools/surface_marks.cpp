#include "tools/surface_marks.h"

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
const Ogre::ColourValue LINE_COLOR(1.0f, 1.0f, 0.2f);

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
  line_.reset();
  line_points_.clear();
  line_mesh_ = ShownMesh();
}

void SurfaceMarks::setSize(float size)
{
  size_ = size;
  for (Ball& ball : balls_) {
    ball.shape->setScale(Ogre::Vector3(size_));
  }
  if (line_) {
    line_->setLineWidth(LINE_WIDTH * size_);
  }
}

/// Relative to the first point, so that floats are exact far from the origin as well.
void SurfaceMarks::setLine(const ShownMesh& mesh, const std::vector<double>& points)
{
  line_mesh_ = mesh;
  line_points_ = points;
  line_.reset();
  const std::size_t count = line_points_.size() / 3;
  if (count < 2) {
    return;
  }
  auto line = std::make_unique<rviz::BillboardLine>(scene_manager_);
  const std::size_t steps = POINTS_PER_LINE - 1;
  line->setMaxPointsPerLine(static_cast<std::uint32_t>(std::min(count, POINTS_PER_LINE)));
  line->setNumLines(static_cast<std::uint32_t>((count - 1 + steps - 1) / steps));
  line->setLineWidth(LINE_WIDTH * size_);
  line->setColor(LINE_COLOR.r, LINE_COLOR.g, LINE_COLOR.b, 1.0f);
  const double* const origin = line_points_.data();
  for (std::size_t i = 0; i < count; ++i) {
    const double* const p = &line_points_[3 * i];
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
  line_ = std::move(line);
  follow({line_mesh_});
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
  if (line_) {
    const ShownMesh* const mesh = find(line_mesh_, shown);
    line_->getSceneNode()->setVisible(mesh != nullptr);
    if (mesh) {
      const auto* const p = line_points_.data();
      line_->setPosition(ogreVector(pointInFixedFrame({p[0], p[1], p[2]}, *mesh)));
      line_->setOrientation(mesh->orientation);
    }
  }
}

}  // namespace rviz_mesh_plugin
