#include "picking/point_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "conversion/mesh_conversion.h"
#include "support/meshes.h"

using rviz_mesh_plugin::CostLayer;
using rviz_mesh_plugin::LabelClusters;
using rviz_mesh_plugin::LayerInfo;
using rviz_mesh_plugin::MeshDataConstPtr;
using rviz_mesh_plugin::PointReport;
using rviz_mesh_plugin::PointValue;
using rviz_mesh_plugin::valueAt;
using Weights = std::array<double, 3>;

namespace {

constexpr float INF = std::numeric_limits<float>::infinity();
constexpr float NAN_ = std::numeric_limits<float>::quiet_NaN();

MeshDataConstPtr hills()
{
  return rviz_mesh_plugin::convert(
      test_meshes::terrain(10, [](double x, double y) { return 0.2 * std::sin(3 * x + y); }));
}

/// The first face of a square, whose corners are the vertices 0, 1 and 3.
PointValue onSquare(const std::vector<float>& costs, const Weights& weights)
{
  static const auto square = rviz_mesh_plugin::convert(test_meshes::square());
  CostLayer layer;
  layer.costs = costs;
  return valueAt(&layer, *square, 0, weights);
}

}  // namespace

TEST(PointValues, interpolates_as_the_areas_of_the_paper_say)
{
  const auto mesh = hills();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-5.0, 5.0), share(0.0, 1.0);
  CostLayer layer;
  for (std::size_t i = 0; i < mesh->vertexCount(); ++i) {
    layer.costs.push_back(static_cast<float>(number(random)));
  }
  for (int i = 0; i < 5000; ++i) {
    const auto face = static_cast<std::uint32_t>(random() % mesh->faceCount());
    double b = share(random), c = share(random);
    if (b + c > 1.0) {
      b = 1.0 - b;
      c = 1.0 - c;
    }
    // Equation 1: each corner by the area of the triangle of the point and the other two.
    std::array<std::array<double, 3>, 3> corner;
    std::array<double, 3> point{};
    const Weights weights{1.0 - b - c, b, c};
    for (unsigned k = 0; k < 3; ++k) {
      for (unsigned axis = 0; axis < 3; ++axis) {
        corner[k][axis] = mesh->vertices[mesh->indices[3 * face + k]].position[axis];
        point[axis] += weights[k] * corner[k][axis];
      }
    }
    double sum = 0.0, areas = 0.0;
    for (unsigned k = 0; k < 3; ++k) {
      const auto &p = corner[(k + 1) % 3], &q = corner[(k + 2) % 3];
      double squared = 0.0;
      for (unsigned m = 0; m < 3; ++m) {
        const unsigned n = (m + 1) % 3, o = (m + 2) % 3;
        const double part =
            (p[n] - point[n]) * (q[o] - point[o]) - (p[o] - point[o]) * (q[n] - point[n]);
        squared += part * part;
      }
      sum += std::sqrt(squared) * layer.costs[mesh->indices[3 * face + k]];
      areas += std::sqrt(squared);
    }
    const PointValue value = valueAt(&layer, *mesh, face, weights);
    ASSERT_EQ(value.kind, PointValue::FINITE);
    ASSERT_NEAR(value.value, sum / areas, 1e-9);
  }
}

TEST(PointValues, lethal_and_unknown_corners_decide_where_they_have_weight)
{
  const Weights middle{0.4, 0.3, 0.3};
  EXPECT_EQ(onSquare({INF, 1, 9, 2}, middle).kind, PointValue::LETHAL);
  EXPECT_EQ(onSquare({1, NAN_, 9, 2}, middle).kind, PointValue::UNKNOWN);
  EXPECT_EQ(onSquare({NAN_, INF, 9, 2}, middle).kind, PointValue::LETHAL);
  EXPECT_EQ(onSquare({INF, NAN_, 9, 2}, middle).kind, PointValue::LETHAL);
  EXPECT_EQ(onSquare({-INF, 1, 9, 2}, middle).kind, PointValue::UNKNOWN);
  EXPECT_EQ(onSquare({1, 1, INF, 1}, middle).kind, PointValue::FINITE) << "a corner of another";
  EXPECT_EQ(onSquare({INF, 1, 9, 2}, {2e-6, 0.5, 0.5 - 2e-6}).kind, PointValue::LETHAL);
  for (const float without : {INF, NAN_}) {
    const PointValue value = onSquare({without, 1, 9, 2}, {5e-7, 0.5, 0.5 - 5e-7});
    EXPECT_EQ(value.kind, PointValue::FINITE);
    EXPECT_NEAR(value.value, 1.5, 1e-6);
    EXPECT_NEAR(onSquare({3, without, 9, 2}, {1, 0, 0}).value, 3.0, 1e-12);
  }
}

TEST(PointValues, are_lethal_where_a_corner_with_weight_is)
{
  const auto square = rviz_mesh_plugin::convert(test_meshes::square());
  CostLayer layer;
  layer.costs = {1, 1, NAN_, 3};  // of the first face: vertices 0, 1 and 3
  LayerInfo info;
  info.comparison = LayerInfo::AT_LEAST;
  info.threshold = 3.0f;
  const auto lethal = [&](const Weights& weights) {
    return rviz_mesh_plugin::isLethalAt(&layer, info, *square, 0, weights);
  };
  EXPECT_TRUE(lethal({0.3, 0.3, 0.4}));
  EXPECT_TRUE(lethal({0.0, 0.0, 1.0}));
  EXPECT_FALSE(lethal({0.5, 0.5, 0.0}));
  info.comparison = LayerInfo::ABOVE;
  EXPECT_FALSE(lethal({0.3, 0.3, 0.4}));
  layer.costs[0] = INF;
  EXPECT_TRUE(lethal({0.3, 0.3, 0.4}));
  layer.costs.pop_back();
  EXPECT_FALSE(lethal({0.3, 0.3, 0.4})) << "of another mesh";
  EXPECT_FALSE(rviz_mesh_plugin::isLethalAt(nullptr, info, *square, 0, {1.0, 0.0, 0.0}));
  layer.costs = {1, 4};
  layer.on_faces = true;
  info.threshold = 3.0f;
  EXPECT_FALSE(lethal({0.3, 0.3, 0.4}));
  EXPECT_TRUE(rviz_mesh_plugin::isLethalAt(&layer, info, *square, 1, {0.3, 0.3, 0.4}));
}

TEST(PointValues, layers_of_faces_have_the_value_of_the_face)
{
  const auto mesh = hills();
  CostLayer layer;
  layer.on_faces = true;
  for (std::size_t i = 0; i < mesh->faceCount(); ++i) {
    layer.costs.push_back(static_cast<float>(i));
  }
  layer.costs[17] = INF;
  layer.costs[18] = NAN_;
  EXPECT_EQ(valueAt(&layer, *mesh, 16, {0.2, 0.2, 0.6}).value, 16.0);
  EXPECT_EQ(valueAt(&layer, *mesh, 17, {0.2, 0.2, 0.6}).kind, PointValue::LETHAL);
  EXPECT_EQ(valueAt(&layer, *mesh, 18, {0.0, 0.0, 1.0}).kind, PointValue::UNKNOWN);
}

TEST(PointValues, what_does_not_fit_the_mesh_is_not_loaded)
{
  const auto mesh = hills();
  EXPECT_EQ(valueAt(nullptr, *mesh, 0, {1, 0, 0}).kind, PointValue::NOT_LOADED);
  CostLayer layer;
  layer.costs.resize(mesh->vertexCount() - 1);
  EXPECT_EQ(valueAt(&layer, *mesh, 0, {1, 0, 0}).kind, PointValue::NOT_LOADED);
  layer.on_faces = true;
  EXPECT_EQ(valueAt(&layer, *mesh, 0, {1, 0, 0}).kind, PointValue::NOT_LOADED);
}

TEST(PointValues, the_nearest_corner_and_labels_are_those_of_brute_force)
{
  const auto mesh = hills();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  LabelClusters labels;
  for (const char* name : {"tree_1", "tree_2", "wall_1", "none_1"}) {
    auto cluster = std::make_shared<rviz_mesh_plugin::LabelCluster>();
    cluster->label = name;
    for (std::uint32_t face = 0; face < mesh->faceCount() && name[0] != 'n'; ++face) {
      if (random() % 3 == 0) {
        cluster->faces.push_back(face);
      }
    }
    labels[name] = cluster;
  }
  for (std::uint32_t face = 0; face < mesh->faceCount(); ++face) {
    const std::array<double, 3> point{share(random), share(random), share(random)};
    const auto distance = [&](std::uint32_t vertex) {
      const auto& p = mesh->vertices[vertex].position;
      return std::hypot(p[0] - point[0], p[1] - point[1], p[2] - point[2]);
    };
    const std::uint32_t* const corners = &mesh->indices[3 * face];
    EXPECT_EQ(rviz_mesh_plugin::nearestCorner(*mesh, face, point),
              *std::min_element(corners, corners + 3,
                                [&](auto a, auto b) { return distance(a) < distance(b); }));
    std::set<std::string> expected, found;
    for (const auto& label : labels) {
      const auto& faces = label.second->faces;
      if (std::count(faces.begin(), faces.end(), face) > 0) {
        expected.insert(label.first);
      }
    }
    rviz_mesh_plugin::addLabelsAt(labels, face, found);
    EXPECT_EQ(found, expected);
  }
}

TEST(PointValues, text)
{
  PointReport report;
  report.face = 12;
  report.vertex = 7;
  report.in_mesh = {"map", {1, -2.5, 0.12345}};
  report.in_fixed_frame = {"map", {1, -2.5, 0.12345}};
  EXPECT_EQ(textOf(report), "face 12, vertex 7 · (1.000, -2.500, 0.123) in map");
  report.in_fixed_frame = {"odom", {-1e-9, 0, 1}};
  report.labels = {"tree_1", "wood_3"};
  report.layers = {{"roughness", {PointValue::FINITE, 0.25}, {}, false},
                   {"steep", {PointValue::LETHAL, 0}, {}, true},
                   {"ridge", {PointValue::UNKNOWN, 0}, {}, false},
                   {"late", {}, {}, false}};
  EXPECT_EQ(textOf(report),
            "face 12, vertex 7 · (1.000, -2.500, 0.123) in map · (0.000, 0.000, 1.000) in odom · "
            "label tree_1, wood_3 · roughness 0.25 · steep lethal · ridge unknown · "
            "late not loaded");
  report.labels.clear();
  LayerInfo info;
  info.unit = "rad";
  info.layer_type = "mesh_layers/RoughnessLayer";
  info.comparison = LayerInfo::ABOVE;
  info.threshold = 0.2f;
  report.layers[0] = {"roughness", {PointValue::FINITE, 0.25}, info, true};
  report.layers[1].info.layer_type = "mesh_layers/LabelLayer";
  report.layers[2].info.infinity = "not reached";
  report.layers[2].value = {PointValue::LETHAL, 0};
  report.layers[2].lethal = true;  // but no layer: a potential
  report.layers.pop_back();
  EXPECT_EQ(textOf(report),
            "face 12, vertex 7 · (1.000, -2.500, 0.123) in map · (0.000, 0.000, 1.000) in odom · "
            "closed by roughness (lethal above 0.2 rad), steep · roughness 0.25 rad · "
            "steep lethal · ridge not reached");
  report.in_mesh.point.fill(-std::numeric_limits<double>::max());
  EXPECT_FALSE(textOf(report).empty());
}
