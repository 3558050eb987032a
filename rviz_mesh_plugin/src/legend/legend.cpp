#include "legend/legend.h"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

#include <OgreFrameListener.h>
#include <OgreHardwarePixelBuffer.h>
#include <OgreMaterial.h>
#include <OgreMaterialManager.h>
#include <OgrePass.h>
#include <OgreResourceGroupManager.h>
#include <OgreRoot.h>
#include <OgreTechnique.h>
#include <OgreTexture.h>
#include <OgreTextureManager.h>
#include <Overlay/OgreOverlay.h>
#include <Overlay/OgreOverlayContainer.h>
#include <Overlay/OgreOverlayManager.h>
#include <QGuiApplication>
#include <QImage>

#include "base/erase_if.h"
#include "rendering/ogre/ogre_compatibility.h"
#include "rendering/ogre/unique_name.h"
#include "rendering/picture_material.h"

namespace rviz_mesh_plugin {
namespace {

/// Below what other plugins put there on purpose (OGRE allows 0 to 650).
constexpr unsigned short Z_ORDER = 300;

/// Between legends and to the border of the view, in pixels of the screen.
constexpr int DISTANCE = 8;

/// Puts all legends side by side, the first at the right border, halfway up the view, and follows
/// the size of this. GUI thread only.
class LegendRow : public Ogre::FrameListener
{
 public:
  static LegendRow& instance()
  {
    static LegendRow row;
    return row;
  }

  void add(LegendPanel* panel)
  {
    if (panels_.empty()) {
      Ogre::Root::getSingleton().addFrameListener(this);
    }
    panels_.push_back(panel);
  }

  void remove(LegendPanel* panel)
  {
    eraseIf(panels_, [&](const LegendPanel* other) { return other == panel; });
    if (panels_.empty() && Ogre::Root::getSingletonPtr()) {
      Ogre::Root::getSingleton().removeFrameListener(this);
    }
  }

  /// Before each frame that RViz draws; @return true, which goes on.
  bool frameStarted(const Ogre::FrameEvent& event) override;

 private:
  std::vector<LegendPanel*> panels_;
};

}  // namespace

/// One legend that is shown: a picture over the 3D view, at its right side. RViz shows overlays in
/// its main view alone: the views of cameras leave them out. GUI thread only.
class LegendPanel
{
 public:
  /// @throw std::runtime_error where OGRE has no overlays
  explicit LegendPanel(LegendContent content) : content_(std::move(content))
  {
    Ogre::OverlayManager* manager = Ogre::OverlayManager::getSingletonPtr();
    if (!manager) {
      throw std::runtime_error("OGRE has been set up without overlays");
    }
    try {
      material_ = createPictureMaterial("Legend material");
      element_ = static_cast<Ogre::OverlayContainer*>(
          manager->createOverlayElement("Panel", uniqueName("Legend panel")));
      element_->setMetricsMode(Ogre::GMM_PIXELS);
      element_->setHorizontalAlignment(Ogre::GHA_RIGHT);
      element_->setMaterialName(material_->getName());
      overlay_ = manager->create(uniqueName("Legend"));
      overlay_->setZOrder(Z_ORDER);
      overlay_->add2D(element_);
      LegendRow::instance().add(this);
    } catch (...) {
      destroy();
      throw;
    }
  }

  ~LegendPanel()
  {
    LegendRow::instance().remove(this);
    destroy();
  }

  LegendPanel(const LegendPanel&) = delete;
  LegendPanel& operator=(const LegendPanel&) = delete;

  const LegendContent& content() const { return content_; }

  void setContent(const LegendContent& content)
  {
    content_ = content;
    drawn_height_ = 0;
  }

  /// Draws it where there is room, in pixels. Throws nothing.
  /// @param height of the legend where @a ratio, of pixels to those of the screen, is 1
  /// @param right from the right side of the view to that of the legend; of the next one after that
  void place(int height, double ratio, int view_width, int view_height, int& right)
  {
    bool fits = false;
    try {
      has_room_ = height >= LEAST_LEGEND_HEIGHT;
      if (has_room_ && (drawn_height_ != height || drawn_ratio_ != ratio)) {
        error_.clear();
        drawn_height_ = height;
        drawn_ratio_ = ratio;
        setPicture(drawLegend(content_, height, ratio));
      }
      has_room_ = has_room_ && right + width_ <= view_width;
      fits = has_room_ && error_.empty();
    } catch (const std::exception& error) {  // Ogre::Exception, std::bad_alloc
      error_ = error.what();
    }
    if (fits) {
      element_->setPosition(static_cast<float>(-right - width_),
                            static_cast<float>((view_height - height_) / 2));
      right += width_ + static_cast<int>(DISTANCE * ratio);
      overlay_->show();
    } else {
      overlay_->hide();
    }
  }

  std::string error() const
  {
    return error_.empty() && !has_room_ ? "the 3D view is too small for it" : error_;
  }

 private:
  void destroy()
  {
    if (Ogre::OverlayManager* manager = Ogre::OverlayManager::getSingletonPtr()) {
      if (overlay_) {
        manager->destroy(overlay_);
      }
      if (element_) {
        manager->destroyOverlayElement(element_);
      }
    }
    removeResource(Ogre::MaterialManager::getSingleton(), material_);
    removeResource(Ogre::TextureManager::getSingleton(), texture_);
  }

  /// @param picture format ARGB32
  void setPicture(const QImage& picture)
  {
    if (!isSet(texture_) || picture.width() != width_ || picture.height() != height_) {
      Ogre::Pass* pass = material_->getTechnique(0)->getPass(0);
      pass->removeAllTextureUnitStates();
      removeResource(Ogre::TextureManager::getSingleton(), texture_);
      width_ = picture.width();
      height_ = picture.height();
      texture_ = Ogre::TextureManager::getSingleton().createManual(
          uniqueName("Legend texture"), Ogre::ResourceGroupManager::DEFAULT_RESOURCE_GROUP_NAME,
          Ogre::TEX_TYPE_2D, static_cast<Ogre::uint>(width_), static_cast<Ogre::uint>(height_), 0,
          Ogre::PF_A8R8G8B8, Ogre::TU_STATIC_WRITE_ONLY);
      Ogre::TextureUnitState* unit = pass->createTextureUnitState(texture_->getName());
      unit->setTextureFiltering(Ogre::TFO_NONE);
      unit->setTextureAddressingMode(Ogre::TextureUnitState::TAM_CLAMP);
      element_->setDimensions(static_cast<float>(width_), static_cast<float>(height_));
    }
    // Rows of this format are never padded. OGRE only reads.
    const Ogre::PixelBox box(static_cast<Ogre::uint32>(width_), static_cast<Ogre::uint32>(height_),
                             1, Ogre::PF_A8R8G8B8, const_cast<uchar*>(picture.constBits()));
    texture_->getBuffer()->blitFromMemory(box);
  }

  LegendContent content_;
  Ogre::TexturePtr texture_;
  Ogre::MaterialPtr material_;
  Ogre::OverlayContainer* element_ = nullptr;
  Ogre::Overlay* overlay_ = nullptr;
  int width_ = 0;
  int height_ = 0;
  int drawn_height_ = 0;  ///< 0: the content has changed since
  double drawn_ratio_ = 1.0;
  std::string error_;  ///< why it could not be drawn; it is not tried again with the same content
  bool has_room_ = true;
};

bool LegendRow::frameStarted(const Ogre::FrameEvent& /*event*/)
{
  const Ogre::OverlayManager* manager = Ogre::OverlayManager::getSingletonPtr();
  if (!manager || !QGuiApplication::instance()) {
    return true;
  }
  // Of the view that overlays have been drawn into last.
  const int view_width = manager->getViewportWidth();
  const int view_height = manager->getViewportHeight();
  const double ratio = qGuiApp->devicePixelRatio();
  const int room = static_cast<int>(view_height / ratio) - 2 * DISTANCE;
  const int height = std::min(LEGEND_HEIGHT, room);
  int right = static_cast<int>(DISTANCE * ratio);
  for (LegendPanel* panel : panels_) {
    panel->place(height, ratio, view_width, view_height, right);
  }
  return true;
}

Legend::Legend() = default;
Legend::~Legend() = default;

void Legend::show(const LegendContent& content)
{
  if (panel_ && panel_->content() == content) {
    return;
  }
  if (panel_) {
    panel_->setContent(content);
  } else if (error_.empty()) {  // else OGRE has no overlays now, nor will it later
    try {
      panel_ = std::make_unique<LegendPanel>(content);
    } catch (const std::exception& error) {  // Ogre::Exception, std::bad_alloc
      error_ = error.what();
    }
  }
}

void Legend::hide()
{
  panel_.reset();
  error_.clear();
}

std::string Legend::error() const
{
  return panel_ ? panel_->error() : error_;
}

}  // namespace rviz_mesh_plugin
