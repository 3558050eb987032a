#include "rendering/text/scene_text.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <OgreCamera.h>
#include <OgreHardwareBufferManager.h>
#include <OgreHardwarePixelBuffer.h>
#include <OgreMaterialManager.h>
#include <OgreMovableObject.h>
#include <OgreRenderQueue.h>
#include <OgreRenderable.h>
#include <OgreTechnique.h>
#include <OgreTextureManager.h>
#include <OgreVertexIndexData.h>
#include <QFont>
#include <QFontMetrics>
#include <QGuiApplication>
#include <QImage>
#include <QPainter>

#include "base/qt_colors.h"
#include "rendering/ogre/unique_name.h"
#include "rendering/picture_material.h"
#include "rendering/text/text_layout.h"

namespace rviz_mesh_plugin {
namespace {

/// After all surfaces, before what is being dragged.
constexpr Ogre::uint8 OVER_THE_SCENE = Ogre::RENDER_QUEUE_OVERLAY - 2;

// In pixels of the screen.
constexpr int FONT_HEIGHT = 13;
constexpr int LINE = 17;
constexpr int BORDER = 5;
constexpr int ABOVE_POINT = 8;
constexpr int WIDEST = 320;

const QColor BEHIND_TEXT(0, 0, 0, 175);

QImage drawText(const std::vector<std::string>& lines, const Rgba8& frame, double ratio)
{
  QFont font(QStringLiteral("Sans Serif"));
  font.setStyleHint(QFont::SansSerif);
  font.setPixelSize(FONT_HEIGHT);
  const QFontMetrics metrics(font);
  std::vector<QString> texts;
  int width = 0;
  for (const std::string& line : lines) {
    texts.push_back(metrics.elidedText(QString::fromStdString(line), Qt::ElideMiddle, WIDEST));
    width = std::max(width, metrics.horizontalAdvance(texts.back()));
  }
  width += 2 * BORDER;
  const int height = static_cast<int>(texts.size()) * LINE + BORDER;
  QImage image(static_cast<int>(width * ratio), static_cast<int>(height * ratio),
               QImage::Format_ARGB32_Premultiplied);
  image.fill(Qt::transparent);
  image.setDevicePixelRatio(ratio);
  QPainter painter{&image};
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setPen(toQColor(frame));
  painter.setBrush(BEHIND_TEXT);
  painter.drawRoundedRect(QRectF(0.5, 0.5, width - 1, height - 1), 3, 3);
  painter.setFont(font);
  painter.setPen(Qt::white);
  int top = BORDER / 2;
  for (const QString& text : texts) {
    painter.drawText(QRect(BORDER, top, width, LINE), Qt::AlignLeft | Qt::AlignVCenter, text);
    top += LINE;
  }
  painter.end();
  return image.convertToFormat(QImage::Format_ARGB32);
}

}  // namespace

/// A picture that faces the camera, of its own size in pixels.
class SceneText::Quad : public Ogre::MovableObject, public Ogre::Renderable
{
 public:
  Quad()
      : Ogre::MovableObject(uniqueName("Text")), material_(createPictureMaterial("Text material"))
  {
    setCastShadows(false);
    setQueryFlags(0);
    bounds_.setExtents(Ogre::Vector3::ZERO, Ogre::Vector3::ZERO);
    auto* declaration = data_.vertexDeclaration;
    declaration->addElement(0, 0, Ogre::VET_FLOAT3, Ogre::VES_POSITION);
    declaration->addElement(0, 3 * sizeof(float), Ogre::VET_FLOAT2, Ogre::VES_TEXTURE_COORDINATES);
    data_.vertexCount = 4;
  }

  ~Quad() override
  {
    removeResource(Ogre::MaterialManager::getSingleton(), material_);
    removeResource(Ogre::TextureManager::getSingleton(), texture_);
  }

  void setOffset(int right, int up)
  {
    right_ = static_cast<float>(right);
    up_ = static_cast<float>(up);
  }
  int width() const { return width_; }
  int height() const { return height_; }

  void show(const QImage& picture, int above)
  {
    Ogre::Pass* pass = material_->getTechnique(0)->getPass(0);
    pass->removeAllTextureUnitStates();
    removeResource(Ogre::TextureManager::getSingleton(), texture_);
    width_ = picture.width();
    height_ = picture.height();
    texture_ = Ogre::TextureManager::getSingleton().createManual(
        uniqueName("Text texture"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME,
        Ogre::TEX_TYPE_2D, static_cast<Ogre::uint>(width_), static_cast<Ogre::uint>(height_), 0,
        Ogre::PF_A8R8G8B8, Ogre::TU_STATIC_WRITE_ONLY);
    // Rows of this format are never padded. OGRE only reads.
    const Ogre::PixelBox box(static_cast<Ogre::uint32>(width_), static_cast<Ogre::uint32>(height_),
                             1, Ogre::PF_A8R8G8B8, const_cast<uchar*>(picture.constBits()));
    texture_->getBuffer()->blitFromMemory(box);
    Ogre::TextureUnitState* unit = pass->createTextureUnitState(texture_->getName());
    unit->setTextureFiltering(Ogre::TFO_NONE);
    unit->setTextureAddressingMode(Ogre::TextureUnitState::TAM_CLAMP);
    // In pixels from the point; whole ones, so that none of the picture is drawn twice.
    const auto left = static_cast<float>(-(width_ / 2)), low = static_cast<float>(above);
    const float right = left + static_cast<float>(width_), high = low + static_cast<float>(height_);
    const std::array<float, 20> vertices{left, low,  0, 0, 1, right, low,  0, 1, 1,
                                         left, high, 0, 0, 0, right, high, 0, 1, 0};
    buffer_ = Ogre::HardwareBufferManager::getSingleton().createVertexBuffer(
        5 * sizeof(float), 4, Ogre::HardwareBuffer::HBU_STATIC_WRITE_ONLY);
    buffer_->writeData(0, sizeof(vertices), vertices.data());
    data_.vertexBufferBinding->setBinding(0, buffer_);
  }

  const Ogre::String& getMovableType() const override
  {
    static const Ogre::String TYPE = "rviz_mesh_plugin/Text";
    return TYPE;
  }
  const Ogre::AxisAlignedBox& getBoundingBox() const override { return bounds_; }
  Ogre::Real getBoundingRadius() const override { return 0.0f; }
  void _notifyCurrentCamera(Ogre::Camera* camera) override
  {
    Ogre::MovableObject::_notifyCurrentCamera(camera);
    camera_ = camera;
  }
  void _updateRenderQueue(Ogre::RenderQueue* queue) override
  {
    queue->addRenderable(this, OVER_THE_SCENE, OGRE_RENDERABLE_DEFAULT_PRIORITY);
  }
  void visitRenderables(Ogre::Renderable::Visitor* visitor, bool /*debug_renderables*/) override
  {
    visitor->visit(this, 0, false);
  }
  const Ogre::MaterialPtr& getMaterial() const override { return material_; }
  void getRenderOperation(Ogre::RenderOperation& operation) override
  {
    operation.operationType = Ogre::RenderOperation::OT_TRIANGLE_STRIP;
    operation.useIndexes = false;
    operation.vertexData = &data_;
    operation.indexData = nullptr;
    operation.srcRenderable = this;
  }

  /// From pixels about the point, which lies where four of them meet.
  void getWorldTransforms(Ogre::Matrix4* transform) const override
  {
    Ogre::Vector3 place = getParentNode()->_getFullTransform().getTrans();
    Ogre::Quaternion turn = Ogre::Quaternion::IDENTITY;
    Ogre::Real pixel = 0.0f;
    if (const auto seen = placeInPicture(place, camera_)) {
      turn = camera_->getDerivedOrientation();
      pixel = seen->meters;
      place += pixel * (turn * Ogre::Vector3(std::round(seen->x) - seen->x + right_,
                                             std::round(seen->y) - seen->y + up_, 0.0f));
    }
    transform->makeTransform(place, Ogre::Vector3(pixel), turn);
  }
  Ogre::Real getSquaredViewDepth(const Ogre::Camera* camera) const override
  {
    return getParentNode()->_getFullTransform().getTrans().squaredDistance(
        camera->getDerivedPosition());
  }
  const Ogre::LightList& getLights() const override { return queryLights(); }

 private:
  Ogre::MaterialPtr material_;
  Ogre::TexturePtr texture_;
  Ogre::AxisAlignedBox bounds_;
  Ogre::VertexData data_;
  Ogre::HardwareVertexBufferSharedPtr buffer_;
  const Ogre::Camera* camera_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  float right_ = 0.0f;
  float up_ = 0.0f;
};

SceneText::SceneText(Ogre::SceneNode* parent) : node_(parent->createChildSceneNode()) {}

SceneText::~SceneText()
{
  if (quad_) {
    node_->detachObject(quad_.get());
  }
  destroySceneNode(node_);
}

void SceneText::show(const std::vector<std::string>& lines, const Rgba8& frame)
{
  if (quad_ && lines == lines_ && frame == frame_) {
    return;
  }
  const double ratio = qGuiApp ? qGuiApp->devicePixelRatio() : 1.0;
  auto quad = std::make_unique<Quad>();
  quad->show(drawText(lines, frame, ratio), static_cast<int>(ABOVE_POINT * ratio));
  const bool visible = !quad_ || quad_->getVisible();
  if (quad_) {
    node_->detachObject(quad_.get());
  }
  quad_ = std::move(quad);
  quad_->setVisible(visible);
  node_->attachObject(quad_.get());
  lines_ = lines;
  frame_ = frame;
}

void SceneText::setPosition(const Ogre::Vector3& position)
{
  node_->setPosition(position);
}

void SceneText::setVisible(bool visible)
{
  node_->setVisible(visible);
}

void SceneText::setOffset(int right, int up)
{
  if (quad_) {
    quad_->setOffset(right, up);
  }
}

int SceneText::width() const
{
  return quad_ ? quad_->width() : 0;
}

int SceneText::height() const
{
  return quad_ ? quad_->height() : 0;
}

}  // namespace rviz_mesh_plugin
