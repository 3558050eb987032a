#pragma once

#include <memory>
#include <string>

#include "rviz_mesh_plugin/cost_coloring.h"

namespace rviz_mesh_plugin {

/// A color bar with the name of the layer, its unit and ticks, at the side of the 3D view. Several
/// legends stand side by side. GUI thread only.
class Legend
{
 public:
  Legend();
  ~Legend();
  Legend(const Legend&) = delete;
  Legend& operator=(const Legend&) = delete;

  /// @param unit empty where it is not known
  void show(const std::string& layer, const std::string& unit, const CostColoring& coloring,
            const CostLimits& limits);
  void hide();

 private:
  class Panel;
  std::unique_ptr<Panel> panel_;
};

}  // namespace rviz_mesh_plugin
