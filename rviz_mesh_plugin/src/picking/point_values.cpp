#include "picking/point_values.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/vectors.h"

namespace rviz_mesh_plugin {
namespace {

/// Corners of less weight do not decide about a point: it lies on the edge across from them.
constexpr double NO_WEIGHT = 1e-6;

constexpr char SEPARATOR[] = " · ";

PointValue mean(const std::array<double, 3>& weights, const std::array<double, 3>& values)
{
  PointValue result{PointValue::FINITE, 0.0};
  double sum = 0.0;
  for (unsigned i = 0; i < 3; ++i) {
    if (std::isfinite(values[i])) {
      result.value += weights[i] * values[i];
      sum += weights[i];
    } else if (weights[i] > NO_WEIGHT) {
      const bool lethal = values[i] > 0.0 || result.kind == PointValue::LETHAL;
      result.kind = lethal ? PointValue::LETHAL : PointValue::UNKNOWN;
    }
  }
  result.value = result.kind == PointValue::FINITE ? result.value / sum : 0.0;
  return result;
}

/// The layers in which the point is lethal, with what is lethal in them; empty where it is in none.
std::string closedBy(const std::vector<PointReport::Layer>& layers)
{
  std::string text;
  for (const PointReport::Layer& layer : layers) {
    if (layer.lethal && !layer.info.layer_type.empty()) {
      const std::string rule = lethalRule(layer.info);
      text += (text.empty() ? "closed by " : ", ") + layer.name +
              (rule.empty() ? rule : " (" + rule + ")");
    }
  }
  return text;
}

template <class... Numbers>
std::string format(const char* how, Numbers... numbers)
{
  char text[200];  // longer ones are cut
  std::snprintf(text, sizeof(text), how, numbers...);
  return text;
}

std::string textOf(const PointReport::Position& position)
{
  std::array<double, 3> p = position.point;
  for (double& coordinate : p) {
    coordinate = std::round(1000.0 * coordinate) / 1000.0 + 0.0;  // never "-0.000"
  }
  return format("(%.3f, %.3f, %.3f)", p[0], p[1], p[2]) + " in " + position.frame;
}

std::string textOf(const PointValue& value, const LayerInfo& info)
{
  switch (value.kind) {
    case PointValue::FINITE:
      return format("%.4g", value.value) + (info.unit.empty() ? "" : " " + info.unit);
    case PointValue::LETHAL:
      return info.infinity;
    case PointValue::UNKNOWN:
      return "unknown";
    default:
      return "not loaded";
  }
}

}  // namespace

PointValue valueAt(const CostLayer* layer, const MeshData& mesh, std::uint32_t face,
                   const std::array<double, 3>& weights)
{
  const std::size_t size = layer && layer->on_faces ? mesh.faceCount() : mesh.vertexCount();
  if (!layer || layer->costs.size() != size) {
    return {};
  }
  if (layer->on_faces) {
    const double value = layer->costs[face];
    return mean({1.0, 0.0, 0.0}, {value, value, value});
  }
  const std::uint32_t* const corners = &mesh.indices[3 * std::size_t{face}];
  return mean(weights,
              {layer->costs[corners[0]], layer->costs[corners[1]], layer->costs[corners[2]]});
}

bool isLethalAt(const CostLayer* layer, const LayerInfo& info, const MeshData& mesh,
                std::uint32_t face, const std::array<double, 3>& weights)
{
  const std::size_t size = layer && layer->on_faces ? mesh.faceCount() : mesh.vertexCount();
  if (!layer || layer->costs.size() != size) {
    return false;
  }
  if (layer->on_faces) {
    return info.isLethal(layer->costs[face]);
  }
  for (unsigned i = 0; i < 3; ++i) {
    const std::uint32_t corner = mesh.indices[3 * std::size_t{face} + i];
    if (weights[i] > NO_WEIGHT && info.isLethal(layer->costs[corner])) {
      return true;
    }
  }
  return false;
}

std::uint32_t nearestCorner(const MeshData& mesh, std::uint32_t face,
                            const std::array<double, 3>& point)
{
  std::array<double, 3> distances;
  for (std::size_t corner = 0; corner < 3; ++corner) {
    distances[corner] = distance(cornerOf(mesh, face, corner), point);
  }
  const auto least = std::min_element(distances.begin(), distances.end());
  return mesh.indices[3 * std::size_t{face} + (least - distances.begin())];
}

void addLabelsAt(const LabelClusters& labels, std::uint32_t face, std::set<std::string>& found)
{
  for (const auto& label : labels) {
    const auto& faces = label.second->faces;
    if (std::binary_search(faces.begin(), faces.end(), face)) {
      found.insert(label.first);
    }
  }
}

std::string textOf(const PointReport& report)
{
  std::string text = "face " + std::to_string(report.face) + ", vertex " +
                     std::to_string(report.vertex) + SEPARATOR + textOf(report.in_mesh);
  if (report.in_fixed_frame.frame != report.in_mesh.frame) {
    text += SEPARATOR + textOf(report.in_fixed_frame);
  }
  if (!report.labels.empty()) {
    text += std::string(SEPARATOR) + "label";
    const char* before = " ";
    for (const std::string& label : report.labels) {
      text += before + label;
      before = ", ";
    }
  }
  if (const std::string closed = closedBy(report.layers); !closed.empty()) {
    text += SEPARATOR + closed;
  }
  for (const PointReport::Layer& layer : report.layers) {
    text += SEPARATOR + layer.name + " " + textOf(layer.value, layer.info);
  }
  return text;
}

}  // namespace rviz_mesh_plugin
