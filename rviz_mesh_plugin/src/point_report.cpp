#include "rviz_mesh_plugin/point_report.h"

#include <algorithm>

#include <rviz/display_context.h>

#include "display_tree.h"
#include "rviz_mesh_plugin/label_lookup.h"
#include "rviz_mesh_plugin/textured_mesh_display.h"
#include "rviz_mesh_plugin/view_geometry.h"

namespace rviz_mesh_plugin {
namespace {

/// The first display that has a layer gives its value.
void addLayer(const std::string& name, const PointValue& value, PointReport& report)
{
  const auto found = std::find_if(report.layers.begin(), report.layers.end(),
                                  [&](const auto& layer) { return layer.name == name; });
  if (found == report.layers.end()) {
    report.layers.push_back({name, value});
  } else if (found->value.kind == PointValue::NOT_LOADED) {
    found->value = value;
  }
}

void add(const TexturedMeshDisplay& display, const SurfaceHit& hit, PointReport& report)
{
  if (!display.has(hit.mesh)) {
    return;
  }
  const MeshAttributes& attributes = display.attributes(*hit.mesh);
  addLabelsAt(attributes.labels, hit.face, report.labels);
  for (const std::string& name : display.costTypes()) {
    const CostLayerConstPtr layer = attributes.cost(name);
    addLayer(name, valueAt(layer.get(), *hit.mesh, hit.face, hit.barycentric), report);
  }
}

}  // namespace

PointReport reportAt(const SurfaceHit& hit, rviz::DisplayContext& context)
{
  PointReport report;
  report.face = hit.face;
  report.vertex = nearestCorner(*hit.mesh, hit.face, hit.point);
  report.in_mesh = {hit.source.frame.empty() ? hit.mesh->frame_id : hit.source.frame, hit.point};
  report.in_fixed_frame = {context.getFixedFrame().toStdString(),
                           pointInFixedFrame(hit.point, hit)};
  const rviz::DisplayGroup* root = context.getRootDisplayGroup();
  visitDisplays<TexturedMeshDisplay>(
      root, DisplayChoice::ENABLED,
      [&](const TexturedMeshDisplay& display) { add(display, hit, report); });
  for (const LabelClusterConstPtr& label : labelsAt(root, *hit.mesh, hit.face)) {
    report.labels.insert(label->label);
  }
  return report;
}

}  // namespace rviz_mesh_plugin
