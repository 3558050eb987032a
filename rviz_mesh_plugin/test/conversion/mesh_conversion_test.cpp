#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/geometry_identity.h"
#include "conversion/mesh_conversion.h"
#include "conversion/validation.h"
#include "support/meshes.h"

using rviz_mesh_plugin::convert;
using rviz_mesh_plugin::identityOf;
using rviz_mesh_plugin::RejectedMessage;
using Vector = std::array<float, 3>;

TEST(Conversion, keeps_vertices_faces_and_their_order)
{
  auto message = test_meshes::terrain(2, [](double x, double y) { return x * y; });
  message.uuid = "some-uuid";
  message.header.frame_id = "world";
  const auto mesh = convert(message);
  EXPECT_EQ(mesh->uuid, "some-uuid");
  EXPECT_EQ(mesh->frame_id, "world");
  ASSERT_EQ(mesh->vertexCount(), 9u);
  ASSERT_EQ(mesh->faceCount(), 8u);
  for (std::size_t i = 0; i < 9; ++i) {
    const auto& p = message.mesh_geometry.vertices[i];
    EXPECT_EQ(mesh->vertices[i].position, (Vector{float(p.x), float(p.y), float(p.z)}));
  }
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_EQ(mesh->indices[i], message.mesh_geometry.faces[i / 3].vertex_indices[i % 3]);
  }
  EXPECT_EQ(mesh->lower, (Vector{-1.0f, -1.0f, -1.0f}));
  EXPECT_EQ(mesh->upper, (Vector{1.0f, 1.0f, 1.0f}));
}

TEST(Conversion, computes_normals_only_where_the_message_has_none)
{
  auto message = test_meshes::square();
  EXPECT_FALSE(convert(message)->normals_given);
  EXPECT_EQ(convert(message)->vertices[0].normal, (Vector{0.0f, 0.0f, 1.0f}));
  EXPECT_EQ(convert(test_meshes::flipped(message))->vertices[0].normal,
            (Vector{0.0f, 0.0f, -1.0f}));
  message.mesh_geometry.vertex_normals.assign(4, test_meshes::point(3.0, 0.0, 0.0));
  message.mesh_geometry.vertex_normals[1] = test_meshes::point(0.0, 0.0, 0.0);
  const auto mesh = convert(message);
  EXPECT_TRUE(mesh->normals_given);
  EXPECT_EQ(mesh->vertices[0].normal, (Vector{1.0f, 0.0f, 0.0f}))
      << "normals are scaled to length 1";
  EXPECT_EQ(mesh->vertices[1].normal, (Vector{0.0f, 0.0f, 0.0f}))
      << "and left alone where that cannot be";
}

TEST(Conversion, tells_a_mesh_that_a_message_has_been_converted_to)
{
  const auto message = test_meshes::terrain(20, [](double x, double y) { return x * y; });
  auto with_normals = message;
  with_normals.mesh_geometry.vertex_normals.resize(441, test_meshes::point(1.0, 2.0, 0.0));
  const auto mesh = convert(message);
  const auto normals_given = convert(with_normals);
  EXPECT_TRUE(isConverted(message, *mesh));
  EXPECT_TRUE(isConverted(with_normals, *normals_given));
  EXPECT_FALSE(isConverted(message, *normals_given));
  EXPECT_FALSE(isConverted(with_normals, *mesh));
  const auto differs = [&](const std::function<void(mesh_msgs::MeshGeometryStamped&)>& change) {
    auto changed = with_normals;
    change(changed);
    return !isConverted(changed, *normals_given);
  };
  EXPECT_TRUE(differs([](auto& m) { m.uuid = "other"; }));
  EXPECT_TRUE(differs([](auto& m) { m.header.frame_id = "odom"; }));
  EXPECT_TRUE(differs([](auto& m) { m.mesh_geometry.vertices.pop_back(); }));
  EXPECT_TRUE(differs([](auto& m) { m.mesh_geometry.vertices.back().z += 1e-3; }));
  EXPECT_TRUE(differs([](auto& m) { m.mesh_geometry.vertices.back().z = NAN; }));
  EXPECT_TRUE(differs([](auto& m) { m.mesh_geometry.faces.pop_back(); }));
  EXPECT_TRUE(differs([](auto& m) { m.mesh_geometry.faces.back().vertex_indices[2] ^= 1; }));
  EXPECT_TRUE(differs([](auto& m) { m.mesh_geometry.vertex_normals.pop_back(); }));
  EXPECT_TRUE(differs([](auto& m) { m.mesh_geometry.vertex_normals.back().y = 3.0; }));
  EXPECT_FALSE(differs([](auto& m) { m.header.seq = 7; }));
}

TEST(Conversion, tells_a_geometry_from_all_others)
{
  const auto message = test_meshes::terrain(300, [](double x, double y) { return x * y; });
  const auto identity = identityOf(*convert(message));
  const auto same = [&](const std::function<void(mesh_msgs::MeshGeometryStamped&)>& change) {
    auto changed = message;
    change(changed);
    return identityOf(*convert(changed)) == identity;
  };
  EXPECT_TRUE(same([](auto& m) { m.mesh_geometry.vertex_normals.resize(301 * 301); }));
  EXPECT_TRUE(same([](auto& m) { m.mesh_geometry.vertices[0].z += 1e-12; })) << "the same float";
  EXPECT_TRUE(same([](auto& m) { m.mesh_geometry.vertices[150].z = 0.0; }) ==
              same([](auto& m) { m.mesh_geometry.vertices[150].z = -0.0; }));
  EXPECT_FALSE(same([](auto& m) { m.uuid = "other"; }));
  EXPECT_FALSE(same(
      [](auto& m) { std::swap(m.mesh_geometry.vertices[7], m.mesh_geometry.vertices[70000]); }));
  EXPECT_FALSE(same([](auto& m) {
    std::swap(m.mesh_geometry.faces[7], m.mesh_geometry.faces[70000]);
  })) << "other numbers";
  EXPECT_FALSE(same([](auto& m) {
    auto& corners = m.mesh_geometry.faces[70000].vertex_indices;
    std::rotate(corners.begin(), corners.begin() + 1, corners.end());
  }));
  for (const std::size_t i : {0, 30000, 90600}) {
    EXPECT_FALSE(same([i](auto& m) { m.mesh_geometry.vertices[i].x += 1e-3; })) << i;
    EXPECT_FALSE(same([i](auto& m) { m.mesh_geometry.vertices[i].z += 1e-3; })) << i;
    EXPECT_FALSE(same([i](auto& m) { m.mesh_geometry.faces[i].vertex_indices[2] ^= 1; })) << i;
  }
}

TEST(Conversion, weights_normals_by_the_area_of_the_faces)
{
  // Vertex 0 belongs to a face of area 2 looking to +z and to one of area 0.5 looking to +x.
  auto message = test_meshes::emptyMesh();
  message.mesh_geometry.vertices = {test_meshes::point(0, 0, 0), test_meshes::point(2, 0, 0),
                                    test_meshes::point(0, 2, 0), test_meshes::point(0, 1, 0),
                                    test_meshes::point(0, 0, 1)};
  test_meshes::addFace(message, 0, 1, 2);
  test_meshes::addFace(message, 0, 3, 4);
  const Vector normal = convert(message)->vertices[0].normal;
  EXPECT_NEAR(normal[0], 0.5 / std::hypot(0.5, 2.0), 1e-6);
  EXPECT_NEAR(normal[1], 0.0, 1e-6);
  EXPECT_NEAR(normal[2], 2.0 / std::hypot(0.5, 2.0), 1e-6);
}

TEST(Conversion, gives_finite_normals_to_degenerate_meshes)
{
  auto message = test_meshes::square();
  for (const double scale : {0.0, 1e-20, 1.0, 1e14}) {
    auto scaled = message;
    for (auto& p : scaled.mesh_geometry.vertices) {
      p = test_meshes::point(p.x * scale, p.y * scale, 0.0);
    }
    const Vector normal = convert(scaled)->vertices[3].normal;
    EXPECT_EQ(normal, (Vector{0.0f, 0.0f, scale > 0.0 ? 1.0f : 0.0f})) << "scaled by " << scale;
  }
  message.mesh_geometry.vertices.push_back(test_meshes::point(5, 5, 5));
  EXPECT_EQ(convert(message)->vertices[4].normal, (Vector{0.0f, 0.0f, 0.0f}))
      << "of a vertex without faces";
}

TEST(Conversion, refuses_what_validation_finds_and_coordinates_that_cannot_be_drawn)
{
  auto message = test_meshes::square();
  message.mesh_geometry.faces[1].vertex_indices[0] = 4;
  EXPECT_THROW(convert(message), RejectedMessage);
  for (const double far : {2e15, -2e15, 3.4e38}) {
    message = test_meshes::square();
    message.mesh_geometry.vertices[2].y = far;
    try {
      convert(message);
      ADD_FAILURE() << far << " m was accepted";
    } catch (const RejectedMessage& rejected) {
      EXPECT_NE(std::string(rejected.what()).find("too far"), std::string::npos) << rejected.what();
    }
  }
}

TEST(Conversion, remarks_where_all_faces_are_degenerate)
{
  auto line = test_meshes::terrain(3, [](double, double) { return 0.0; });
  for (auto& vertex : line.mesh_geometry.vertices) {
    vertex = test_meshes::point(vertex.x, vertex.x, 0);
  }
  EXPECT_EQ(convert(line)->remark.rfind("all 18 faces are degenerate", 0), 0u)
      << convert(line)->remark;
  auto corners = test_meshes::terrain(3, [](double, double) { return 0.0; });
  for (auto& face : corners.mesh_geometry.faces) {
    face.vertex_indices[1] = face.vertex_indices[0];
  }
  EXPECT_EQ(convert(corners)->remark.rfind("all 18 faces are degenerate", 0), 0u);
  corners.mesh_geometry.faces[17].vertex_indices = {0, 1, 4};
  EXPECT_EQ(convert(corners)->remark, "") << "one can be seen";
  for (auto& vertex : corners.mesh_geometry.vertices) {
    vertex = test_meshes::point(0, 0, 0);
  }
  EXPECT_EQ(convert(corners)->remark.rfind("all 16 vertices lie in one point, (0, 0, 0)", 0), 0u)
      << convert(corners)->remark;
}

TEST(Conversion, remarks_where_float_rounds_by_more_than_a_tenth_of_the_median_edge)
{
  // At 2^22 m, floats are 0.5 m apart: they may be 0.25 m beside.
  const double far = 4194304.0 + 1000.0;
  for (const double edge : {0.1, 1.0, 2.4, 2.6, 10.0}) {
    auto message = test_meshes::emptyMesh();
    // Two edges along the axes each, of this length, and a longer one.
    for (int i = 0; i < 3; ++i) {
      message.mesh_geometry.vertices.push_back(
          test_meshes::point(far + (i == 1 ? edge : 0.0), i == 2 ? edge : 0.0, 0.0));
    }
    test_meshes::addFace(message, 0, 1, 2);
    const std::string remark = convert(message)->remark;
    EXPECT_EQ(remark.find(
                  "drawn with an error of up to 0.25 m, more than a tenth of the median edge (") !=
                  std::string::npos,
              edge < 2.5)
        << edge << ": " << remark;
    for (auto& vertex : message.mesh_geometry.vertices) {
      vertex.x -= far;
    }
    EXPECT_EQ(convert(message)->remark, "") << "near the origin";
  }
}

TEST(Conversion, rounds_colors_to_bytes)
{
  const auto layer = convert(test_meshes::colors({test_meshes::color(0.0f, 0.5f, 1.0f, 0.2f)}));
  EXPECT_EQ(layer->colors, (std::vector<rviz_mesh_plugin::Rgba8>{{0, 128, 255, 51}}));
}

TEST(Conversion, of_a_large_mesh_is_the_same_as_face_by_face)
{
  const auto message = test_meshes::terrain(400, [](double x, double y) { return x * x * y; });
  const auto& geometry = message.mesh_geometry;
  const auto mesh = convert(message);
  std::vector<std::array<double, 3>> sums(geometry.vertices.size(), {0.0, 0.0, 0.0});
  for (std::size_t i = 0; i < geometry.faces.size(); ++i) {
    const auto& corners = geometry.faces[i].vertex_indices;
    ASSERT_TRUE(std::equal(corners.begin(), corners.end(), mesh->indices.begin() + 3 * i));
    const auto& a = geometry.vertices[corners[0]];
    const auto& b = geometry.vertices[corners[1]];
    const auto& c = geometry.vertices[corners[2]];
    for (const std::uint32_t corner : corners) {
      sums[corner][0] += (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
      sums[corner][1] += (b.z - a.z) * (c.x - a.x) - (b.x - a.x) * (c.z - a.z);
      sums[corner][2] += (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const auto& p = geometry.vertices[i];
    ASSERT_EQ(mesh->vertices[i].position, (Vector{float(p.x), float(p.y), float(p.z)}));
    const double length = std::hypot(sums[i][0], sums[i][1], sums[i][2]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_NEAR(mesh->vertices[i].normal[axis], sums[i][axis] / length, 1e-3);
    }
  }
  const auto again = convert(message);
  EXPECT_EQ(std::memcmp(again->vertices.data(), mesh->vertices.data(),
                        mesh->vertices.size() * sizeof(mesh->vertices[0])),
            0)
      << "normals differ from run to run";
}

TEST(Conversion, refuses_exactly_what_validation_finds)
{
  using Message = mesh_msgs::MeshGeometryStamped;
  const double nan = std::nan("");
  const std::function<void(Message&)> faults[] = {
      [](Message&) {},
      [](Message& message) { message.header.frame_id.clear(); },
      [](Message& message) { message.uuid.clear(); },
      [](Message& message) { message.mesh_geometry.vertices.clear(); },
      [](Message& message) { message.mesh_geometry.faces.clear(); },
      [nan](Message& message) { message.mesh_geometry.vertices[3].x = nan; },
      [](Message& message) { message.mesh_geometry.vertices[0].z = 1e60; },
      [](Message& message) { message.mesh_geometry.vertices[0].z = -INFINITY; },
      [](Message& message) { message.mesh_geometry.faces[1].vertex_indices[2] = 4; },
      [](Message& message) { message.mesh_geometry.faces[0].vertex_indices[1] = 0xFFFFFFFF; },
      [](Message& message) { message.mesh_geometry.faces[0].vertex_indices[1] = 0; },
      [](Message& message) { message.mesh_geometry.vertex_normals.resize(3); },
      [](Message& message) { message.mesh_geometry.vertex_normals.resize(4); },
      [nan](Message& message) {
        message.mesh_geometry.vertex_normals.resize(4);
        message.mesh_geometry.vertex_normals[2].y = nan;
      },
      [](Message& message) {
        message.mesh_geometry.vertex_normals.resize(4);
        message.mesh_geometry.vertex_normals[2].y = 1e39;
      }};
  std::size_t refused = 0;
  for (const auto& fault : faults) {
    auto message = test_meshes::square();
    fault(message);
    const std::string expected = summarize(rviz_mesh_plugin::check(message));
    std::string reason;
    try {
      convert(message);
    } catch (const RejectedMessage& rejected) {
      reason = rejected.what();
    }
    EXPECT_EQ(reason, expected);
    refused += reason.empty() ? 0 : 1;
  }
  EXPECT_EQ(refused, 11u);
}
