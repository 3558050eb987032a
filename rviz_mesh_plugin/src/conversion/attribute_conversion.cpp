#include "conversion/attribute_conversion.h"

#include <iterator>
#include <unordered_map>
#include <utility>

#include "labels/label_faces.h"

namespace rviz_mesh_plugin {
namespace {

template <class Message>
std::shared_ptr<CostLayer> toLayer(const Message& message, const std::vector<float>& costs,
                                   bool on_faces)
{
  refuse(check(message));
  auto layer = std::make_shared<CostLayer>();
  layer->uuid = message.uuid;
  layer->type = message.type;
  layer->on_faces = on_faces;
  layer->stamp = message.header.stamp.toNSec();
  layer->costs = costs;
  layer->summary = summarizeCosts(layer->costs);
  return layer;
}

std::vector<Finding> checkLabel(const mesh_msgs::MeshFaceCluster& cluster)
{
  auto findings = check(cluster);
  if (cluster.label.empty()) {
    findings.push_back({"label_empty", "a cluster has no label", "choose one such as 'tree_1'"});
  }
  return findings;
}

}  // namespace

std::shared_ptr<CostLayer> convert(const mesh_msgs::MeshVertexCostsStamped& message)
{
  return toLayer(message, message.mesh_vertex_costs.costs, false);
}

std::shared_ptr<CostLayer> convert(const mesh_msgs::MeshFaceCostsStamped& message)
{
  return toLayer(message, message.mesh_face_costs.costs, true);
}

CostUpdateConstPtr convert(const mesh_msgs::MeshVertexCostsSparseStamped& message)
{
  refuse(check(message));
  auto update = std::make_shared<CostUpdate>();
  update->uuid = message.uuid;
  update->type = message.type;
  update->stamp = message.header.stamp.toNSec();
  update->vertices = message.mesh_vertex_costs.vertices;
  update->costs = message.mesh_vertex_costs.costs;
  return update;
}

LayerInfos convert(const mesh_msgs::LayerInfoArray& message)
{
  LayerInfos infos;
  for (const mesh_msgs::LayerInfo& layer : message.layers) {
    LayerInfo info;
    info.layer_type = layer.layer_type;
    info.unit = layer.unit;
    info.infinity = layer.infinity.empty() ? info.infinity : layer.infinity;
    // Those that are not known here are none that can be looked for in the values.
    info.comparison = layer.comparison < mesh_msgs::LayerInfo::OTHER
                          ? static_cast<LayerInfo::Comparison>(layer.comparison)
                          : LayerInfo::OTHER;
    info.threshold = layer.threshold;
    info.cost_limit = layer.cost_limit;
    info.lethal = layer.lethal;
    infos.emplace(layer.name, std::move(info));
  }
  return infos;
}

Rgba8 toRgba8(const std_msgs::ColorRGBA& color)
{
  const auto to_byte = [](float channel) {
    return static_cast<std::uint8_t>(channel * 255.0f + 0.5f);
  };
  return {to_byte(color.r), to_byte(color.g), to_byte(color.b), to_byte(color.a)};
}

ColorLayerConstPtr convert(const mesh_msgs::MeshVertexColorsStamped& message)
{
  refuse(check(message));
  auto layer = std::make_shared<ColorLayer>();
  layer->uuid = message.uuid;
  layer->colors.reserve(message.mesh_vertex_colors.vertex_colors.size());
  for (const auto& color : message.mesh_vertex_colors.vertex_colors) {
    layer->colors.push_back(toRgba8(color));
  }
  return layer;
}

LabelSetConstPtr convert(const mesh_msgs::MeshFaceCluster& message)
{
  refuse(checkLabel(message));
  auto labels = std::make_shared<LabelSet>();
  labels->clusters.push_back({message.label, message.face_indices});
  sortFaces(labels->clusters.back().faces);
  return labels;
}

LabelSetConstPtr convertLabels(const std::string& uuid,
                               const std::vector<mesh_msgs::MeshFaceCluster>& clusters, bool all,
                               std::string& left_out)
{
  auto labels = std::make_shared<LabelSet>();
  labels->uuid = uuid;
  labels->all = all;
  std::unordered_map<std::string, std::size_t> places;
  std::size_t bad = 0;
  left_out.clear();
  for (const auto& cluster : clusters) {
    const auto findings = checkLabel(cluster);
    if (!findings.empty()) {
      left_out = bad++ == 0 ? summarize(findings) : left_out;
      continue;
    }
    const auto place = places.emplace(cluster.label, labels->clusters.size());
    if (place.second) {
      labels->clusters.push_back({cluster.label, cluster.face_indices});
    } else {
      auto& faces = labels->clusters[place.first->second].faces;
      faces.insert(faces.end(), cluster.face_indices.begin(), cluster.face_indices.end());
    }
  }
  for (LabelCluster& cluster : labels->clusters) {
    sortFaces(cluster.faces);
  }
  if (bad > 0) {
    left_out = std::to_string(bad) + " of " + std::to_string(clusters.size()) +
               " labels are left out: " + left_out;
  }
  return labels;
}

}  // namespace rviz_mesh_plugin
