#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "conversion/material_conversion.h"
#include "support/meshes.h"

using rviz_mesh_plugin::convert;
using rviz_mesh_plugin::NONE;
using rviz_mesh_plugin::RejectedMessage;
using rviz_mesh_plugin::Rgba8;

namespace {

mesh_msgs::MeshMaterialsStamped materials(const std::vector<std::vector<std::uint32_t>>& clusters,
                                          const std::vector<std::uint32_t>& cluster_materials,
                                          std::size_t count)
{
  mesh_msgs::MeshMaterialsStamped message;
  message.header.frame_id = "map";
  message.uuid = "mesh";
  for (const auto& faces : clusters) {
    message.mesh_materials.clusters.emplace_back();
    message.mesh_materials.clusters.back().face_indices = faces;
  }
  message.mesh_materials.cluster_materials = cluster_materials;
  message.mesh_materials.materials.resize(count);
  return message;
}

mesh_msgs::MeshTexture texture(const std::string& encoding, std::uint32_t width,
                               std::uint32_t height, const std::vector<std::uint8_t>& data,
                               std::uint32_t step)
{
  mesh_msgs::MeshTexture message;
  message.uuid = "mesh";
  message.image.encoding = encoding;
  message.image.width = width;
  message.image.height = height;
  message.image.step = step;
  message.image.data = data;
  return message;
}

}  // namespace

TEST(Materials, go_through_cluster_materials_and_the_last_cluster_of_a_face_counts)
{
  // More clusters than materials, in another order.
  const auto made = convert(materials({{4, 0}, {2}, {0, 7}}, {1, 0, 1}, 2));
  EXPECT_EQ(made->faces, (std::vector<std::uint32_t>{0, 2, 4, 7}));
  EXPECT_EQ(made->face_materials, (std::vector<std::uint32_t>{1, 0, 1, 1}));
  EXPECT_EQ(convert(materials({{3}, {3}, {3}}, {0, 2, 1}, 3))->face_materials,
            std::vector<std::uint32_t>{1});
}

TEST(Materials, are_the_same_with_any_gaps_between_faces)
{
  std::mt19937 random(7);
  for (const std::uint32_t limit : {40u, 4000000000u}) {
    std::vector<std::vector<std::uint32_t>> clusters(30);
    std::vector<std::uint32_t> indices;
    std::map<std::uint32_t, std::uint32_t> expected;
    for (auto& faces : clusters) {
      indices.push_back(random() % 5);
      for (std::size_t i = 0; i < 10; ++i) {
        faces.push_back(static_cast<std::uint32_t>(random() % 40) * (limit / 40));
        expected[faces.back()] = indices.back();
      }
    }
    const auto made = convert(materials(clusters, indices, 5));
    ASSERT_EQ(made->faces.size(), expected.size());
    std::size_t i = 0;
    for (const auto& pair : expected) {
      EXPECT_EQ(made->faces[i], pair.first);
      EXPECT_EQ(made->face_materials[i++], pair.second);
    }
  }
  // A single face with the greatest index takes no table of 16 GB.
  EXPECT_EQ(convert(materials({{0xFFFFFFFF}}, {0}, 1))->faces[0], 0xFFFFFFFFu);
}

TEST(Materials, have_a_texture_only_where_they_say_so)
{
  auto message = materials({}, {}, 3);
  auto& given = message.mesh_materials.materials;
  given[0].texture_index = 5;
  given[1].texture_index = 6;
  given[1].has_texture = true;
  given[1].color = test_meshes::color(0.0f, 0.5f, 1.0f, 0.2f);
  given[2].texture_index = 0xFFFFFFFF;  // the "-1" of servers in the field
  given[2].has_texture = true;
  message.mesh_materials.vertex_tex_coords.resize(1);
  message.mesh_materials.vertex_tex_coords[0].u = 0.25f;
  message.mesh_materials.vertex_tex_coords[0].v = 0.75f;
  message.mesh_materials.clusters.resize(1);
  message.mesh_materials.clusters[0].label = "of/any\nkind";
  message.mesh_materials.cluster_materials = {0};
  const auto made = convert(message);
  EXPECT_EQ(made->materials[0].texture_index, NONE);
  EXPECT_EQ(made->materials[1].texture_index, 6u);
  EXPECT_EQ(made->materials[1].color, (Rgba8{0, 128, 255, 51}));
  EXPECT_EQ(made->materials[2].texture_index, NONE);
  EXPECT_EQ(made->texture_coordinates[0], (std::array<float, 2>{0.25f, 0.25f})) << "v from the top";
}

TEST(Textures, of_every_encoding_become_rgba)
{
  const Rgba8 first{10, 20, 30, 40}, second{50, 60, 70, 80};
  const Rgba8 opaque_first{10, 20, 30, 255}, opaque_second{50, 60, 70, 255};
  const Rgba8 grey_first{10, 10, 10, 255}, grey_second{50, 50, 50, 255};
  struct Case
  {
    const char* encoding;
    std::vector<std::uint8_t> data;
    Rgba8 pixels[2];
  };
  const std::vector<Case> cases = {
      {"rgb8", {10, 20, 30, 50, 60, 70}, {opaque_first, opaque_second}},
      {"8UC3", {10, 20, 30, 50, 60, 70}, {opaque_first, opaque_second}},
      {"bgr8", {30, 20, 10, 70, 60, 50}, {opaque_first, opaque_second}},
      {"rgba8", {10, 20, 30, 40, 50, 60, 70, 80}, {first, second}},
      {"8UC4", {10, 20, 30, 40, 50, 60, 70, 80}, {first, second}},
      {"bgra8", {30, 20, 10, 40, 70, 60, 50, 80}, {first, second}},
      {"mono8", {10, 50}, {grey_first, grey_second}},
      {"8UC1", {10, 50}, {grey_first, grey_second}},
      {"mono16", {9, 10, 9, 50}, {grey_first, grey_second}},
      {"16UC1", {9, 10, 9, 50}, {grey_first, grey_second}},
      {"rgb16", {9, 10, 9, 20, 9, 30, 9, 50, 9, 60, 9, 70}, {opaque_first, opaque_second}},
      {"rgba16", {9, 10, 9, 20, 9, 30, 9, 40, 9, 50, 9, 60, 9, 70, 9, 80}, {first, second}}};
  for (const Case& one : cases) {
    // Two rows, each with three bytes of padding.
    const auto row = static_cast<std::uint32_t>(one.data.size());
    std::vector<std::uint8_t> data = one.data;
    data.insert(data.end(), {1, 2, 3});
    data.insert(data.end(), one.data.begin(), one.data.end());
    data.insert(data.end(), {1, 2, 3});
    auto message = texture(one.encoding, 2, 2, data, row + 3);
    message.texture_index = 3;
    const auto made = convert(message);
    EXPECT_EQ(made->pixels,
              (std::vector<Rgba8>{one.pixels[0], one.pixels[1], one.pixels[0], one.pixels[1]}))
        << one.encoding;
    EXPECT_EQ(made->translucent, one.pixels[0].alpha < 255) << one.encoding;
    EXPECT_EQ(made->width, 2u);
    EXPECT_EQ(made->index, 3u);
    message.image.data.pop_back();
    EXPECT_THROW(convert(message), RejectedMessage) << one.encoding;
  }
  auto big_endian = texture("mono16", 1, 1, {10, 9}, 2);
  big_endian.image.is_bigendian = 1;
  EXPECT_EQ(convert(big_endian)->pixels[0], grey_first);
}

TEST(Textures, too_large_for_graphics_cards_are_halved)
{
  const std::uint32_t side = 2 * rviz_mesh_plugin::GREATEST_TEXTURE_SIDE + 2;
  std::vector<std::uint8_t> data(3 * side);
  for (std::size_t i = 0; i < data.size(); ++i) {
    data[i] = i < side ? 100 : i < 2 * side ? 50 : 30;
  }
  const auto made = convert(texture("mono8", side, 3, data, side));
  EXPECT_EQ(made->width, side / 4);
  EXPECT_EQ(made->height, 1u);
  EXPECT_EQ(made->pixels.size(), side / 4);
  EXPECT_EQ(made->pixels[7].red, 75);
}
