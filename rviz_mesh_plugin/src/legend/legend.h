#pragma once

#include <memory>
#include <string>

#include "legend/legend_picture.h"

namespace rviz_mesh_plugin {

class LegendPanel;

/// A color bar with the name of the layer, its unit and ticks, at the right side of the 3D view.
/// Several legends stand side by side; in a view too small for them they are left out. GUI thread
/// only.
class Legend
{
 public:
  Legend();
  ~Legend();
  Legend(const Legend&) = delete;
  Legend& operator=(const Legend&) = delete;

  /// Drawn with the next frame; cheap where nothing has changed. Throws nothing.
  void show(const LegendContent& content);
  void hide();

  /// Why there was no legend in the newest frame though it is to be shown; empty where it is drawn.
  std::string error() const;

 private:
  std::unique_ptr<LegendPanel> panel_;  ///< only while shown
  std::string error_;                   ///< why there could be none
};

}  // namespace rviz_mesh_plugin
