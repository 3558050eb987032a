#include "displays/shown_legend.h"

#include "legend/legend.h"
#include "mesh_view/mesh_painter.h"
#include "properties/cost_properties.h"
#include "properties/mesh_properties.h"

namespace rviz_mesh_plugin {

ShownLegend::ShownLegend() = default;

ShownLegend::~ShownLegend() = default;

void ShownLegend::update(const MeshProperties& properties, const MeshPainters& painters)
{
  const MeshPainter* painter = nullptr;
  for (const MeshPainters::Mesh& mesh : painters.meshes()) {
    if (!painter && mesh.painter->costs()) {
      painter = mesh.painter.get();
    }
  }
  if (!painter || !properties.costs().legend()) {
    hide();
    return;
  }
  const std::string layer = properties.costs().costsType();
  const std::string unit = properties.costs().unit();
  const CostColoring& coloring = painter->coloring();
  const CostLimits limits = limitsOf(coloring, painter->costs()->summary);
  if (legend_ && layer == layer_ && unit == unit_ && coloring == coloring_ &&
      limits.lower == limits_.lower && limits.upper == limits_.upper) {
    return;
  }
  if (!legend_) {
    legend_ = std::make_unique<Legend>();
  }
  legend_->show(layer, unit, coloring, limits);
  layer_ = layer;
  unit_ = unit;
  coloring_ = coloring;
  limits_ = limits;
}

void ShownLegend::hide()
{
  legend_.reset();
}

std::string ShownLegend::error() const
{
  return legend_ ? legend_->error() : std::string();
}

}  // namespace rviz_mesh_plugin
