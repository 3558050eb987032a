// Against the definitions, written down once more.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "selection/face_criterion.h"
#include "threads/cancellation.h"

using rviz_mesh_plugin::CostLayer;
using rviz_mesh_plugin::FaceBits;
using rviz_mesh_plugin::FaceCriterion;
using rviz_mesh_plugin::facesThatMeet;
using rviz_mesh_plugin::HeightCriterion;
using rviz_mesh_plugin::LayerCriterion;
using rviz_mesh_plugin::LayerInfo;
using rviz_mesh_plugin::ListCriterion;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::SlopeCriterion;
using Faces = std::vector<std::uint32_t>;

namespace {

constexpr float INF = std::numeric_limits<float>::infinity();
constexpr float UNKNOWN = std::numeric_limits<float>::quiet_NaN();
const double PI = std::acos(-1.0);

/// Any triangles, some without an area.
MeshData soup(std::size_t vertices, std::size_t faces, std::mt19937& random)
{
  std::uniform_real_distribution<float> place(-3.0f, 3.0f);
  MeshData mesh;
  mesh.vertices.resize(vertices);
  for (auto& vertex : mesh.vertices) {
    vertex.position = {place(random), place(random), place(random)};
  }
  for (std::size_t i = 0; i < 3 * faces; ++i) {
    mesh.indices.push_back(random() % vertices);
  }
  return mesh;
}

std::shared_ptr<CostLayer> layerOf(std::vector<float> costs, bool on_faces = false)
{
  auto layer = std::make_shared<CostLayer>();
  layer->type = "steepness";
  layer->costs = std::move(costs);
  layer->on_faces = on_faces;
  return layer;
}

std::array<double, 3> corner(const MeshData& mesh, std::size_t face, std::size_t number)
{
  const auto& p = mesh.vertices[mesh.indices[3 * face + number]].position;
  return {p[0], p[1], p[2]};
}

template <class Meets>
Faces where(const MeshData& mesh, const Meets& meets)
{
  Faces faces;
  for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
    if (meets(face)) {
      faces.push_back(face);
    }
  }
  return faces;
}

/// Faces 0..2 of vertices 0..8, each with its own.
MeshData threeFaces()
{
  MeshData mesh;
  mesh.vertices.resize(9);
  for (std::uint32_t i = 0; i < 9; ++i) {
    mesh.vertices[i].position = {float(i % 3 == 1), float(i % 3 == 2), 0.0f};
    mesh.indices.push_back(i);
  }
  return mesh;
}

Faces found(const FaceCriterion& criterion, const MeshData& mesh)
{
  return facesThatMeet(criterion, mesh).faces();
}

}  // namespace

TEST(FaceCriterion, a_layer_at_all_corners_or_at_one)
{
  std::mt19937 random(1);
  for (const std::size_t face_count : {0, 1, 63, 64, 65, 1000}) {
    const MeshData mesh = soup(40, face_count, random);
    std::vector<float> costs(40);
    for (float& cost : costs) {
      const unsigned kind = random() % 6;
      cost = kind == 0 ? UNKNOWN : kind == 1 ? INF : float(random() % 100) / 100.0f;
    }
    LayerCriterion criterion{layerOf(costs), LayerInfo()};
    for (const bool all : {true, false}) {
      criterion.all_corners = all;
      for (const auto values :
           {LayerCriterion::RANGE, LayerCriterion::LETHAL, LayerCriterion::UNKNOWN}) {
        criterion.values = values;
        criterion.range = {0.2, 0.7};
        const Faces expected = where(mesh, [&](std::uint32_t face) {
          int count = 0;
          for (int i = 0; i < 3; ++i) {
            const float cost = costs[mesh.indices[3 * face + i]];
            count += values == LayerCriterion::RANGE    ? cost >= 0.2 && cost <= 0.7
                     : values == LayerCriterion::LETHAL ? cost == INF
                                                        : cost != cost;
          }
          return all ? count == 3 : count > 0;
        });
        EXPECT_EQ(found(criterion, mesh), expected) << face_count << all << values;
      }
    }
  }
}

TEST(FaceCriterion, lethal_and_unknown_lie_in_no_range)
{
  const MeshData mesh = threeFaces();
  LayerCriterion criterion{layerOf({UNKNOWN, UNKNOWN, UNKNOWN, INF, INF, INF, 0.0f, 1e30f, 5.0f}),
                           LayerInfo()};
  EXPECT_EQ(found(criterion, mesh), Faces{2}) << "without any limit";
  criterion.all_corners = false;
  EXPECT_EQ(found(criterion, mesh), Faces{2});
  criterion.range = {5.0, INF};
  EXPECT_EQ(found(criterion, mesh), Faces{2}) << "both ends included";
  criterion.range = {5.000001, 6.0};
  EXPECT_TRUE(found(criterion, mesh).empty());
}

TEST(FaceCriterion, lethal_is_what_the_map_says)
{
  const MeshData mesh = threeFaces();
  LayerCriterion criterion{layerOf({0.3f, 0.3f, 0.3f, 0.4f, 0.5f, INF, UNKNOWN, UNKNOWN, 0.1f}),
                           LayerInfo()};
  criterion.values = LayerCriterion::LETHAL;
  EXPECT_TRUE(found(criterion, mesh).empty()) << "without layer_info only +inf is";
  criterion.info.comparison = LayerInfo::ABOVE;
  criterion.info.threshold = 0.3f;
  EXPECT_EQ(found(criterion, mesh), Faces{1});
  criterion.info.comparison = LayerInfo::AT_LEAST;
  EXPECT_EQ(found(criterion, mesh), (Faces{0, 1}));
}

TEST(FaceCriterion, a_layer_of_faces_has_a_value_for_each)
{
  const MeshData mesh = threeFaces();
  LayerCriterion criterion{layerOf({0.1f, UNKNOWN, 0.3f}, true), LayerInfo()};
  criterion.range = {0.2, 0.4};
  EXPECT_EQ(found(criterion, mesh), Faces{2});
  criterion.values = LayerCriterion::UNKNOWN;
  EXPECT_EQ(found(criterion, mesh), Faces{1});
}

TEST(FaceCriterion, a_layer_of_another_size_is_refused)
{
  const MeshData mesh = threeFaces();
  EXPECT_THROW(found(LayerCriterion{layerOf({1.0f}), LayerInfo()}, mesh), std::invalid_argument);
  EXPECT_THROW(found(LayerCriterion{layerOf(std::vector<float>(9, 1.0f), true), LayerInfo()}, mesh),
               std::invalid_argument);
}

TEST(FaceCriterion, the_height_is_that_of_the_middle_in_whatever_frame)
{
  std::mt19937 random(2);
  const MeshData mesh = soup(100, 500, random);
  HeightCriterion criterion{{2.0 / 7, 3.0 / 7, 6.0 / 7}, 10.0, {9.5, 10.7}};
  const Faces expected = where(mesh, [&](std::uint32_t face) {
    double height = 10.0;
    for (int i = 0; i < 3; ++i) {
      const auto p = corner(mesh, face, i);
      height += (2.0 * p[0] + 3.0 * p[1] + 6.0 * p[2]) / 7.0 / 3.0;
    }
    return height >= 9.5 && height <= 10.7;
  });
  EXPECT_GT(expected.size(), 50u);
  EXPECT_EQ(found(criterion, mesh), expected);
}

TEST(FaceCriterion, the_slope_is_the_angle_to_up_from_floor_to_ceiling)
{
  MeshData mesh;
  for (int degrees = 0; degrees <= 180; degrees += 15) {
    const double angle = degrees * PI / 180.0;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.resize(first + 3);  // turned about x
    mesh.vertices[first + 1].position = {1.0f, 0.0f, 0.0f};
    mesh.vertices[first + 2].position = {0.0f, float(std::cos(angle)), float(std::sin(angle))};
    mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2});
  }
  mesh.indices.insert(mesh.indices.end(), {0, 0, 1});  // no area
  const double degree = PI / 180.0;
  EXPECT_EQ(found(SlopeCriterion{{0, 0, 1}, {-1 * degree, 31 * degree}}, mesh), (Faces{0, 1, 2}));
  EXPECT_EQ(found(SlopeCriterion{{0, 0, 1}, {89 * degree, 91 * degree}}, mesh), (Faces{6}));
  EXPECT_EQ(found(SlopeCriterion{{0, 0, 1}, {179 * degree, 181 * degree}}, mesh), (Faces{12}));
  EXPECT_EQ(found(SlopeCriterion{}, mesh).size(), 13u) << "without an area there is no normal";
  EXPECT_EQ(found(SlopeCriterion{{0, 0, -1}, {0, 1 * degree}}, mesh), (Faces{12}))
      << "of a mesh that stands on its head";
}

TEST(FaceCriterion, a_list_without_those_that_the_mesh_does_not_have)
{
  const MeshData mesh = threeFaces();
  EXPECT_EQ(found(ListCriterion{std::make_shared<const Faces>(Faces{2, 0, 7})}, mesh),
            (Faces{0, 2}));
}

TEST(FaceCriterion, it_can_be_given_up)
{
  std::mt19937 random(3);
  const MeshData mesh = soup(10, 100, random);
  const std::atomic<bool> canceled{true};
  EXPECT_THROW(facesThatMeet(HeightCriterion(), mesh, &canceled), rviz_mesh_plugin::Canceled);
  EXPECT_THROW(facesThatMeet(SlopeCriterion(), mesh, &canceled), rviz_mesh_plugin::Canceled);
}
