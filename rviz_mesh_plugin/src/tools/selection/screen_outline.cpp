#include "tools/selection/screen_outline.h"

#include <cmath>

#include <OgreCamera.h>
#include <OgreHardwareBufferManager.h>
#include <OgreMaterialManager.h>
#include <OgreRenderOperation.h>
#include <OgreRenderQueue.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreViewport.h>

#include "rendering/ogre/ogre_compatibility.h"
#include "rendering/ogre/unique_name.h"
#include "rendering/picture_material.h"

namespace rviz_mesh_plugin {
namespace {

constexpr Rgba8 LIGHT{255, 255, 255, 255};
constexpr Rgba8 DARK{30, 30, 30, 200};
constexpr Rgba8 FILL{255, 140, 0, 40};

/// In pixels.
constexpr double LIGHT_WIDTH = 2.0;
constexpr double DARK_WIDTH = 4.0;

}  // namespace

ScreenOutline::ScreenOutline(Ogre::SceneManager* scene_manager)
    : Ogre::MovableObject(uniqueName("Outline")),
      node_(scene_manager->getRootSceneNode()->createChildSceneNode()),
      material_(createPictureMaterial("Outline material"))
{
  setUseIdentityProjection(true);
  setUseIdentityView(true);
  setCastShadows(false);
  setQueryFlags(0);
  bounds_.setInfinite();
  auto* declaration = data_.vertexDeclaration;
  declaration->addElement(0, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION);
  declaration->addElement(0, offsetof(Vertex, color), Ogre::VET_COLOUR_ABGR, Ogre::VES_DIFFUSE);
}

ScreenOutline::~ScreenOutline()
{
  if (isAttached()) {
    node_->detachObject(this);
  }
  destroySceneNode(node_);
  removeResource(Ogre::MaterialManager::getSingleton(), material_);
}

void ScreenOutline::show(const Ogre::Viewport& viewport, const std::vector<Pixel>& corners)
{
  vertices_.clear();
  addLines(viewport, corners);
  upload(viewport);
}

void ScreenOutline::showBox(const Ogre::Viewport& viewport, const Pixel& corner,
                            const Pixel& opposite)
{
  vertices_.clear();
  const std::vector<Pixel> corners{
      corner, {opposite.x, corner.y}, opposite, {corner.x, opposite.y}};
  const auto points = pointsOf(corners, viewport);
  for (const unsigned i : {0, 1, 2, 0, 2, 3}) {
    vertices_.push_back(
        {static_cast<float>(points[i][0]), static_cast<float>(points[i][1]), 0.0f, FILL});
  }
  addLines(viewport, corners);
  upload(viewport);
}

void ScreenOutline::addLines(const Ogre::Viewport& viewport, const std::vector<Pixel>& corners)
{
  for (const bool light : {false, true}) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      addLine(viewport, corners[i], corners[(i + 1) % corners.size()],
              light ? LIGHT_WIDTH : DARK_WIDTH, light ? LIGHT : DARK);
    }
  }
}

/// As two triangles, so long that lines meet at corners without a gap.
void ScreenOutline::addLine(const Ogre::Viewport& viewport, const Pixel& from, const Pixel& to,
                            double width, const Rgba8& color)
{
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  if (length <= 0.0) {
    return;
  }
  const double along_x = 0.5 * width * (to.x - from.x) / length;
  const double along_y = 0.5 * width * (to.y - from.y) / length;
  const auto vertex = [&](const Pixel& pixel, double along, double across) {
    const PicturePoint middle = pointOf(pixel, viewport);
    const double right = along * along_x - across * along_y;
    const double down = along * along_y + across * along_x;
    return Vertex{static_cast<float>(middle[0] + 2.0 * right / viewport.getActualWidth()),
                  static_cast<float>(middle[1] - 2.0 * down / viewport.getActualHeight()), 0.0f,
                  color};
  };
  const Vertex corners[] = {vertex(from, -1, -1), vertex(to, 1, -1), vertex(to, 1, 1),
                            vertex(from, -1, 1)};
  for (const unsigned i : {0, 1, 2, 0, 2, 3}) {
    vertices_.push_back(corners[i]);
  }
}

void ScreenOutline::upload(const Ogre::Viewport& viewport)
{
  viewport_ = nullptr;
  if (vertices_.empty()) {
    return;
  }
  if (!isSet(buffer_) || buffer_->getNumVertices() < vertices_.size()) {
    buffer_ = Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
        sizeof(Vertex), 2 * vertices_.size(), Ogre::HardwareBuffer::HBU_DYNAMIC_WRITE_ONLY);
    data_.vertexBufferBinding->setBinding(0, buffer_);
  }
  buffer_->writeData(0, vertices_.size() * sizeof(Vertex), vertices_.data(), false);
  data_.vertexCount = vertices_.size();
  viewport_ = &viewport;
  if (!isAttached()) {
    node_->attachObject(this);  // not before there is something to draw: it has no bounds
  }
}

const Ogre::String& ScreenOutline::getMovableType() const
{
  static const Ogre::String TYPE = "rviz_mesh_plugin/Outline";
  return TYPE;
}

bool ScreenOutline::isVisible() const
{
  return viewport_ && viewport_ == drawn_in_ && Ogre::MovableObject::isVisible();
}

void ScreenOutline::_notifyCurrentCamera(Ogre::Camera* camera)
{
  Ogre::MovableObject::_notifyCurrentCamera(camera);
  drawn_in_ = camera->getViewport();
}

void ScreenOutline::_updateRenderQueue(Ogre::RenderQueue* queue)
{
  queue->addRenderable(this, Ogre::RENDER_QUEUE_OVERLAY - 1, OGRE_RENDERABLE_DEFAULT_PRIORITY);
}

void ScreenOutline::visitRenderables(Ogre::Renderable::Visitor* visitor, bool /*debug_renderables*/)
{
  visitor->visit(this, 0, false);
}

void ScreenOutline::getRenderOperation(Ogre::RenderOperation& operation)
{
  operation.operationType = Ogre::RenderOperation::OT_TRIANGLE_LIST;
  operation.useIndexes = false;
  operation.vertexData = &data_;
  operation.indexData = nullptr;
  operation.srcRenderable = this;
}

void ScreenOutline::getWorldTransforms(Ogre::Matrix4* transform) const
{
  *transform = Ogre::Matrix4::IDENTITY;
}

Ogre::Real ScreenOutline::getSquaredViewDepth(const Ogre::Camera* /*camera*/) const
{
  return 0.0f;
}

}  // namespace rviz_mesh_plugin
