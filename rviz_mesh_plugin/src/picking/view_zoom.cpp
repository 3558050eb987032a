#include "picking/view_zoom.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <OgreCamera.h>
#include <OgreSceneNode.h>
#include <OgreViewport.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/vector_property.h>
#include <rviz/view_controller.h>

#include "picking/view_geometry.h"

namespace rviz_mesh_plugin {
namespace {

/// Around what is seen, as a share of it.
constexpr float MARGIN = 1.1f;

/// Of what has no size, in meters.
constexpr float LEAST_RADIUS = 0.05f;

/// Null where a view has none; asking RViz for it would be an error in its log then.
template <class Property>
Property* find(const rviz::ViewController& view, const char* name)
{
  for (int i = 0; i < view.numChildren(); ++i) {
    if (view.childAt(i)->getName() == name) {
      return dynamic_cast<Property*>(view.childAt(i));
    }
  }
  return nullptr;
}

/// Of a sphere that fits into the picture, from the camera to its middle.
float distanceFor(float radius, const Ogre::Camera& camera)
{
  const float up = 0.5f * camera.getFOVy().valueRadians();
  const float aside = std::atan(std::tan(up) * camera.getAspectRatio());
  return MARGIN * radius / std::sin(std::min(up, aside));
}

}  // namespace

Ogre::AxisAlignedBox boxInFixedFrame(const Bounds& bounds, const ShownMesh& mesh)
{
  Ogre::AxisAlignedBox box;
  for (unsigned corner = 0; corner < 8; ++corner) {
    std::array<double, 3> point{};
    for (unsigned axis = 0; axis < 3; ++axis) {
      point[axis] = (corner >> axis & 1) != 0 ? bounds.upper[axis] : bounds.lower[axis];
    }
    box.merge(ogreVector(pointInFixedFrame(point, mesh)));
  }
  return box;
}

bool zoomTo(rviz::ViewController& view, const Ogre::AxisAlignedBox& box)
{
  const Ogre::Vector3 middle = box.getCenter();
  view.update(0.0f, 0.0f);  // else its camera stands where it stood in the last frame
  const float radius = std::max(box.getHalfSize().length(), LEAST_RADIUS);
  const Ogre::Camera* const camera = view.getCamera();
  if (!camera) {
    view.lookAt(middle);
    return true;
  }
  const Ogre::SceneNode* const frame = camera->getParentSceneNode();  // of positions
  const auto inFrame = [&](const Ogre::Vector3& point) {
    return frame
               ? frame->_getDerivedOrientation().Inverse() * (point - frame->_getDerivedPosition())
               : point;
  };
  auto* const focal_point = find<rviz::VectorProperty>(view, "Focal Point");
  auto* const distance = find<rviz::FloatProperty>(view, "Distance");
  // Some views do not look straight at their point: from it to the camera, for a distance of 1.
  const Ogre::Vector3 away =
      focal_point && distance ? (inFrame(camera->getDerivedPosition()) - focal_point->getVector()) /
                                    std::max(distance->getFloat(), 1e-6f)
                              : Ogre::Vector3::ZERO;
  // Looking at a point from where it is, RViz's camera turns: it looks from another side then.
  const Ogre::Vector3 direction = camera->getDerivedDirection();
  auto* const yaw = find<rviz::FloatProperty>(view, "Yaw");
  auto* const pitch = find<rviz::FloatProperty>(view, "Pitch");
  auto* const roll = find<rviz::FloatProperty>(view, "Roll");
  std::vector<std::pair<rviz::FloatProperty*, float>> angles;
  for (auto* const angle : {yaw, pitch, roll}) {
    if (angle) {
      angles.emplace_back(angle, angle->getFloat());
    }
  }
  view.lookAt(middle);
  for (const auto& angle : angles) {
    angle.first->setFloat(angle.second);
  }
  const float meters = distanceFor(radius, *camera);
  if (auto* scale = find<rviz::FloatProperty>(view, "Scale")) {
    const Ogre::Viewport* const viewport = camera->getViewport();
    if (viewport) {
      const int pixels = std::min(viewport->getActualWidth(), viewport->getActualHeight());
      scale->setFloat(static_cast<float>(pixels) / (2.0f * MARGIN * radius));
    }
  } else if (focal_point && distance) {
    // Also where looking at a point moves it to the ground.
    focal_point->setVector(inFrame(middle - meters * direction) - meters * away);
    distance->setFloat(meters);
  } else if (auto* position = find<rviz::VectorProperty>(view, "Position")) {
    position->setVector(inFrame(middle - meters * direction));
  }
  view.update(0.0f, 0.0f);
  return !find<rviz::FloatProperty>(view, "Scale") ||
         camera->getDerivedDirection().dotProduct(middle - camera->getDerivedPosition()) > 0.0f;
}

}  // namespace rviz_mesh_plugin
