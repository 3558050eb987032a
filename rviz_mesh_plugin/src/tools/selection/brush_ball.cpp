#include "tools/selection/brush_ball.h"

#include <rviz/ogre_helpers/shape.h>

#include "picking/view_geometry.h"
#include "rendering/ogre_compatibility.h"

namespace rviz_mesh_plugin {
namespace {

constexpr float ALPHA = 0.4f;

/// Brightness, so that it shows on the highlight, too.
constexpr float ADDING = 1.0f;
constexpr float REMOVING = 0.1f;

}  // namespace

BrushBall::BrushBall(Ogre::SceneManager* scene_manager) : scene_manager_(scene_manager) {}

BrushBall::~BrushBall() = default;

void BrushBall::show(const std::array<double, 3>& center, double radius, bool adding)
{
  if (!shape_) {
    shape_ = std::make_unique<rviz::Shape>(rviz::Shape::Sphere, scene_manager_);
  }
  shape_->setPosition(ogreVector(center));
  shape_->setScale(Ogre::Vector3(static_cast<float>(2.0 * radius)));
  const float light = adding ? ADDING : REMOVING;
  shape_->setColor(light, light, light, ALPHA);
}

void BrushBall::hide()
{
  shape_.reset();
}

}  // namespace rviz_mesh_plugin
