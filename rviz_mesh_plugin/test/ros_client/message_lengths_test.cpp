#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/GetLabelColors.h>
#include <mesh_msgs/GetUUIDs.h>
#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshLabelColors.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <mesh_msgs/TriangleMeshStamped.h>

#include "ros_client/message_lengths.h"
#include "support/meshes.h"
#include "support/raw_messages.h"

using rviz_mesh_plugin::findFalseLength;

namespace {

constexpr std::uint32_t HUGE = 0x20000000;

template <class Message>
bool canBeRead(std::vector<std::uint8_t> bytes)
{
  Message message;
  try {
    ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    ros::serialization::deserialize(stream, message);
    return true;
  } catch (const ros::serialization::StreamOverrunException&) {
    return false;
  }
}

/// What is found is what roscpp runs into, wherever the message ends; and a length that lies is
/// found wherever it stands.
template <class Message>
void expectFound(const Message& message, std::size_t lengths)
{
  const auto bytes = raw_messages::bytesOf(message);
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const std::vector<std::uint8_t> part(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));
    ASSERT_EQ(findFalseLength<Message>(part.data(), size).empty(), canBeRead<Message>(part))
        << size << " of " << bytes.size();
  }
  auto longer = bytes;
  longer.resize(longer.size() + 7, 0xFF);
  EXPECT_EQ(findFalseLength<Message>(longer.data(), longer.size()), "") << "as roscpp reads it";
  std::size_t found = 0;
  for (std::size_t at = 0; at + 4 <= bytes.size(); ++at) {
    auto lying = bytes;
    std::memcpy(lying.data() + at, &HUGE, 4);
    found += findFalseLength<Message>(lying.data(), lying.size()).empty() ? 0 : 1;
  }
  // Each length, and where its upper bytes are hit.
  EXPECT_GE(found, lengths);
  const std::vector<std::uint8_t> ones(4096, 0xFF);
  EXPECT_NE(findFalseLength<Message>(ones.data(), ones.size()), "");
}

mesh_msgs::MeshFaceCluster cluster()
{
  mesh_msgs::MeshFaceCluster message;
  message.face_indices = {1, 2, 3};
  message.label = "tree_1";
  return message;
}

}  // namespace

TEST(MessageLengths, are_looked_at_in_every_type)
{
  auto geometry = test_meshes::square();
  geometry.mesh_geometry.vertex_normals.resize(4);
  expectFound(geometry, 5);
  expectFound(test_meshes::costs("slope", {1.0f, 2.0f}), 4);
  expectFound(test_meshes::colors({test_meshes::color(1, 0, 0)}), 3);
  mesh_msgs::MeshVertexCostsSparseStamped update;
  update.mesh_vertex_costs.vertices = {1, 2};
  update.mesh_vertex_costs.costs = {1, 2};
  expectFound(update, 5);
  mesh_msgs::MeshMaterialsStamped materials;
  materials.mesh_materials.clusters = {cluster(), cluster()};
  materials.mesh_materials.materials.resize(2);
  materials.mesh_materials.cluster_materials = {0, 1};
  materials.mesh_materials.vertex_tex_coords.resize(4);
  expectFound(materials, 10);
  mesh_msgs::MeshTexture texture;
  texture.image.encoding = "rgb8";
  texture.image.data.resize(12);
  expectFound(texture, 4);
  expectFound(cluster(), 2);
  mesh_msgs::MeshLabelColors colors;
  colors.labels = {"tree_1", "", "tree_2"};
  colors.colors.resize(3);
  expectFound(colors, 6);
  mesh_msgs::TriangleMeshStamped all;
  all.mesh.textures = {texture.image, texture.image};
  all.mesh.clusters = {cluster()};
  expectFound(all, 14);
}

TEST(MessageLengths, of_answers_of_services_too)
{
  mesh_msgs::GetUUIDs::Response uuids;
  uuids.uuids = {"a", "bc"};
  expectFound(uuids, 3);
  mesh_msgs::GetLabelColors::Response colors;
  colors.labels = {"tree_1"};
  colors.colors.resize(1);
  expectFound(colors, 3);
}

TEST(MessageLengths, that_lie_are_told_with_the_numbers)
{
  auto message = test_meshes::square();
  auto bytes = raw_messages::bytesOf(message);
  const std::size_t vertices = 12 + 4 + 3 + 4 + 4;  // after header and uuid
  std::memcpy(bytes.data() + vertices, &HUGE, 4);
  EXPECT_EQ(
      findFalseLength<mesh_msgs::MeshGeometryStamped>(bytes.data(), bytes.size()),
      "an array of 536870912 geometry_msgs/Point needs 12884901888 bytes, but only 128 of the "
      "message's 159 are left; it is damaged, or its publisher does not keep to the format");
  EXPECT_EQ(findFalseLength<mesh_msgs::MeshGeometryStamped>(bytes.data(), 3),
            "the message ends in the middle, after 3 bytes; it is damaged, or its publisher does "
            "not keep to the format");
}
