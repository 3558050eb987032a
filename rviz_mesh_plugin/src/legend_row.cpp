#include "legend_row.h"

#include <algorithm>
#include <exception>

#include <OgreRoot.h>
#include <Overlay/OgreOverlayManager.h>
#include <QGuiApplication>

namespace rviz_mesh_plugin {
namespace {

/// Between legends and to the border of the view, in pixels of the screen.
constexpr int DISTANCE = 8;

}  // namespace

LegendRow& LegendRow::instance()
{
  static LegendRow row;
  return row;
}

void LegendRow::add(LegendPanel* panel)
{
  if (panels_.empty()) {
    Ogre::Root::getSingleton().addFrameListener(this);
  }
  panels_.push_back(panel);
}

void LegendRow::remove(LegendPanel* panel)
{
  panels_.erase(std::remove(panels_.begin(), panels_.end(), panel), panels_.end());
  if (panels_.empty() && Ogre::Root::getSingletonPtr()) {
    Ogre::Root::getSingleton().removeFrameListener(this);
  }
}

void LegendRow::place(LegendPanel& panel, int height, double ratio, int view_width, int view_height,
                      int* right)
{
  if (panel.drawn_height != height || panel.drawn_ratio != ratio) {
    panel.error.clear();
    panel.drawn_height = height;
    panel.drawn_ratio = ratio;
    panel.overlay.setPicture(drawLegend(panel.content, height, ratio));
  }
  panel.has_room = *right + panel.overlay.width() <= view_width;
  const bool fits = panel.error.empty() && panel.has_room;
  panel.overlay.setVisible(fits);
  if (fits) {
    panel.overlay.setPosition(*right, (view_height - panel.overlay.height()) / 2);
    *right += panel.overlay.width() + static_cast<int>(DISTANCE * ratio);
  }
}

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
    try {
      if (height < LEAST_LEGEND_HEIGHT) {
        panel->has_room = false;
        panel->overlay.setVisible(false);
      } else {
        place(*panel, height, ratio, view_width, view_height, &right);
      }
    } catch (const std::exception& error) {  // Ogre::Exception, std::bad_alloc
      panel->error = error.what();
      panel->overlay.setVisible(false);
    }
  }
  return true;
}

}  // namespace rviz_mesh_plugin
