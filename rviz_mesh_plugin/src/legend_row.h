#pragma once

#include <string>
#include <vector>

#include <OgreFrameListener.h>

#include "legend_overlay.h"
#include "rviz_mesh_plugin/legend_picture.h"

namespace rviz_mesh_plugin {

/// One legend that is shown.
struct LegendPanel
{
  LegendContent content;
  LegendOverlay overlay;
  int drawn_height = 0;  ///< 0: the content has changed since
  double drawn_ratio = 1.0;
  std::string error;  ///< why it could not be drawn; it is not tried again with the same content
  bool has_room = true;
};

/// Puts all legends side by side, the first at the right border, halfway up the view, and follows
/// the size of this. GUI thread only.
class LegendRow : public Ogre::FrameListener
{
 public:
  static LegendRow& instance();

  void add(LegendPanel* panel);
  void remove(LegendPanel* panel);

  /// Before each frame that RViz draws; @return true, which goes on.
  bool frameStarted(const Ogre::FrameEvent& event) override;

 private:
  static void place(LegendPanel& panel, int height, double ratio, int view_width, int view_height,
                    int* right);

  std::vector<LegendPanel*> panels_;
};

}  // namespace rviz_mesh_plugin
