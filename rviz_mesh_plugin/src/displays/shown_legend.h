#pragma once

#include <memory>
#include <string>

#include "coloring/cost_coloring.h"

namespace rviz_mesh_plugin {

class Legend;
class MeshPainters;
class MeshProperties;

/// The legend of a mesh display: there while a cost layer is drawn and the
/// properties ask for it. GUI thread only.
class ShownLegend
{
 public:
  ShownLegend();
  ~ShownLegend();

  void update(const MeshProperties& properties, const MeshPainters& painters);
  void hide();

  /// Why it is not drawn though it is to be; else empty.
  std::string error() const;

 private:
  std::unique_ptr<Legend> legend_;  ///< only while shown
  std::string layer_;
  std::string unit_;
  CostColoring coloring_;
  CostLimits limits_;
};

}  // namespace rviz_mesh_plugin
