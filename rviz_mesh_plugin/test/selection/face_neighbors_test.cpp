#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "selection/face_neighbors.h"
#include "selection/face_selection.h"
#include "threads/cancellation.h"

using rviz_mesh_plugin::FaceBits;
using rviz_mesh_plugin::FaceNeighbors;
using rviz_mesh_plugin::FaceSelection;
using rviz_mesh_plugin::joinedCorners;
using rviz_mesh_plugin::MeshData;
using Faces = FaceNeighbors::Faces;
using Position = std::array<float, 3>;

namespace {

FaceNeighbors neighborsOf(const MeshData& mesh)
{
  return FaceNeighbors(joinedCorners(mesh));
}

/// Of one face, ascending.
Faces neighborsOf(const FaceNeighbors& neighbors, std::uint32_t face)
{
  FaceSelection one(neighbors.faceCount());
  one.select({face});
  return neighbors.grow(one.bits());
}

/// Waves over cells x cells squares, some corners with vertices of their own (-0 for 0, too).
MeshData waves(std::uint32_t cells, double height, std::mt19937& random)
{
  MeshData mesh;
  const auto vertex = [&](std::uint32_t i, std::uint32_t j) {
    const auto z = static_cast<float>(height * std::sin(0.7 * i) * std::cos(0.9 * j));
    mesh.vertices.push_back({{static_cast<float>(i), static_cast<float>(j), z}, {}});
  };
  for (std::uint32_t i = 0; i <= cells; ++i) {
    for (std::uint32_t j = 0; j <= cells; ++j) {
      vertex(i, j);
    }
  }
  for (std::uint32_t i = 0; i < cells; ++i) {
    for (std::uint32_t j = 0; j < cells; ++j) {
      const std::uint32_t a = i * (cells + 1) + j, b = a + cells + 1;
      for (const std::uint32_t corner : {a, b, a + 1, a + 1, b, b + 1}) {
        mesh.indices.push_back(corner);
        if (random() % 3 == 0) {
          auto copy = mesh.vertices[corner];
          for (float& coordinate : copy.position) {
            coordinate = coordinate == 0.0f ? -0.0f : coordinate;
          }
          mesh.indices.back() = static_cast<std::uint32_t>(mesh.vertices.size());
          mesh.vertices.push_back(copy);
        }
      }
    }
  }
  return mesh;
}

/// Any faces between few places: edges of many faces, the same faces again, faces without area.
MeshData soup(std::size_t faces, std::uint32_t places, std::mt19937& random)
{
  MeshData mesh;
  for (std::uint32_t i = 0; i < 2 * places; ++i) {
    const auto at = [&](std::uint32_t factor) {
      return static_cast<float>((i % places) * factor % 11);
    };
    mesh.vertices.push_back({{at(1), at(3), at(7)}, {}});
  }
  for (std::size_t i = 0; i < 3 * faces; ++i) {
    mesh.indices.push_back(random() % (2 * places));
  }
  return mesh;
}

Position corner(const MeshData& mesh, std::uint32_t face, unsigned i)
{
  return mesh.vertices[mesh.indices[3 * face + i]].position;
}

std::set<Position> cornersOf(const MeshData& mesh, std::uint32_t face)
{
  std::set<Position> corners;
  for (unsigned i = 0; i < 3; ++i) {
    Position position = corner(mesh, face, i);
    for (float& coordinate : position) {
      coordinate += 0.0f;
    }
    corners.insert(position);
  }
  return corners;
}

/// By the definition: two of three corners in the same place.
std::vector<Faces> bruteForce(const MeshData& mesh)
{
  std::vector<Faces> neighbors(mesh.faceCount());
  for (std::uint32_t a = 0; a < mesh.faceCount(); ++a) {
    const auto of_a = cornersOf(mesh, a);
    for (std::uint32_t b = 0; b < mesh.faceCount(); ++b) {
      const auto of_b = cornersOf(mesh, b);
      const auto both = std::count_if(of_a.begin(), of_a.end(),
                                      [&](const Position& place) { return of_b.count(place); });
      if (a != b && of_a.size() == 3 && of_b.size() == 3 && both >= 2) {
        neighbors[a].push_back(b);
      }
    }
  }
  return neighbors;
}

std::array<double, 3> unitNormal(const MeshData& mesh, std::uint32_t face)
{
  double u[3], v[3];
  for (unsigned i = 0; i < 3; ++i) {
    u[i] = static_cast<double>(corner(mesh, face, 1)[i]) - corner(mesh, face, 0)[i];
    v[i] = static_cast<double>(corner(mesh, face, 2)[i]) - corner(mesh, face, 0)[i];
  }
  std::array<double, 3> normal{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                               u[0] * v[1] - u[1] * v[0]};
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  for (double& coordinate : normal) {
    coordinate = length > 0.0 ? coordinate / length : 0.0;
  }
  return normal;
}

Faces floodBruteForce(const MeshData& mesh, const std::vector<Faces>& neighbors,
                      std::uint32_t start, double max_angle)
{
  std::set<std::uint32_t> region{start};
  for (bool grown = true; grown;) {
    grown = false;
    for (const std::uint32_t face : Faces(region.begin(), region.end())) {
      const auto normal = unitNormal(mesh, face);
      for (const std::uint32_t other : neighbors[face]) {
        const auto towards = unitNormal(mesh, other);
        double cosine = 0.0, length = 0.0, own = 0.0;
        for (unsigned i = 0; i < 3; ++i) {
          cosine += normal[i] * towards[i];
          length += towards[i] * towards[i];
          own += normal[i] * normal[i];
        }
        const bool reached = own > 0.0 && (length == 0.0 || cosine >= std::cos(max_angle) - 1e-12);
        grown |= reached && region.insert(other).second;
      }
    }
  }
  return Faces(region.begin(), region.end());
}

std::vector<MeshData> samples()
{
  std::mt19937 random(3);
  std::vector<MeshData> meshes;
  meshes.push_back(waves(9, 1.5, random));
  for (const std::uint32_t places : {4u, 9u, 40u}) {
    meshes.push_back(soup(150, places, random));
  }
  return meshes;
}

}  // namespace

TEST(FaceNeighborsTest, are_the_faces_with_two_corners_in_the_same_places)
{
  for (const MeshData& mesh : samples()) {
    const FaceNeighbors neighbors = neighborsOf(mesh);
    const auto expected = bruteForce(mesh);
    ASSERT_EQ(neighbors.faceCount(), mesh.faceCount());
    for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
      ASSERT_EQ(neighborsOf(neighbors, face), expected[face]) << face;
    }
    EXPECT_TRUE(neighborsOf(neighbors, static_cast<std::uint32_t>(mesh.faceCount())).empty());
  }
}

TEST(FaceNeighborsTest, growing_and_shrinking_go_by_one_ring)
{
  std::mt19937 random(5);
  for (const MeshData& mesh : samples()) {
    const FaceNeighbors neighbors = neighborsOf(mesh);
    const auto beside = bruteForce(mesh);
    for (const unsigned part : {1u, 2u, 5u, 30u}) {
      FaceSelection selection(mesh.faceCount());
      Faces some;
      for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
        if (random() % part == 0) {
          some.push_back(face);
        }
      }
      selection.select(some);
      Faces outside, inside;
      for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
        const auto selected = [&](std::uint32_t other) { return selection.contains(other); };
        if (!selected(face) && std::any_of(beside[face].begin(), beside[face].end(), selected)) {
          outside.push_back(face);
        }
        if (selected(face) && !std::all_of(beside[face].begin(), beside[face].end(), selected)) {
          inside.push_back(face);
        }
      }
      EXPECT_EQ(neighbors.grow(selection.bits()), outside);
      EXPECT_EQ(neighbors.shrink(selection.bits()), inside);
    }
  }
}

TEST(FaceNeighborsTest, a_region_ends_where_normals_turn_too_far)
{
  std::set<std::size_t> sizes;
  for (const MeshData& mesh : samples()) {
    const FaceNeighbors neighbors = neighborsOf(mesh);
    const auto beside = bruteForce(mesh);
    for (const double angle : {0.1, 0.4, 0.61, 0.9, 1.7, 3.0, 4.0}) {
      for (std::uint32_t face = 0; face < mesh.faceCount(); face += 17) {
        const Faces region = neighbors.flood(mesh, face, angle);
        ASSERT_EQ(region, floodBruteForce(mesh, beside, face, std::min(angle, 3.1415926535897932)))
            << face << ", " << angle;
        sizes.insert(region.size());
      }
    }
  }
  EXPECT_GT(sizes.size(), 15u) << "regions of many sizes";
}

TEST(FaceNeighborsTest, a_flat_part_is_one_region_at_any_angle)
{
  std::mt19937 random(1);
  MeshData mesh = waves(4, 0.0, random);
  EXPECT_EQ(neighborsOf(mesh).flood(mesh, 5, 0.0).size(), 32u);
  EXPECT_TRUE(neighborsOf(mesh).flood(mesh, 32, 1.0).empty()) << "there is no such face";
}

TEST(FaceNeighborsTest, a_region_stays_among_open_faces)
{
  std::mt19937 random(1);
  const MeshData mesh = waves(4, 0.0, random);
  const FaceNeighbors neighbors = neighborsOf(mesh);
  const auto beside = bruteForce(mesh);
  std::set<std::size_t> sizes;
  for (unsigned part = 2; part < 8; ++part) {
    Faces faces;
    for (std::uint32_t face = 0; face < mesh.faceCount(); ++face) {
      if (random() % part != 0) {
        faces.push_back(face);
      }
    }
    const FaceBits open(mesh.faceCount(), faces);
    std::set<std::uint32_t> expected{faces.front()};
    for (std::size_t before = 0; before != expected.size();) {
      before = expected.size();
      for (const auto face : Faces(expected.begin(), expected.end())) {
        for (const auto other : beside[face]) {
          if (open.contains(other)) {
            expected.insert(other);
          }
        }
      }
    }
    EXPECT_EQ(neighbors.flood(mesh, faces.front(), 3.2, nullptr, &open),
              Faces(expected.begin(), expected.end()));
    sizes.insert(expected.size());
  }
  EXPECT_GT(sizes.size(), 2u);
}

TEST(FaceNeighborsTest, nothing_comes_of_nothing)
{
  const MeshData mesh;
  const FaceNeighbors neighbors = neighborsOf(mesh);
  EXPECT_EQ(neighbors.faceCount(), 0u);
  EXPECT_TRUE(neighborsOf(neighbors, 0).empty());
  EXPECT_TRUE(neighbors.grow(FaceBits(10)).empty());
  EXPECT_TRUE(neighbors.flood(mesh, 0, 1.0).empty());
}

TEST(FaceNeighborsTest, work_can_be_given_up)
{
  std::mt19937 random(1);
  const MeshData mesh = waves(4, 0.0, random);
  const std::atomic<bool> canceled{true};
  EXPECT_THROW(FaceNeighbors(joinedCorners(mesh), &canceled), rviz_mesh_plugin::Canceled);
  EXPECT_THROW(neighborsOf(mesh).flood(mesh, 0, 1.0, nullptr, nullptr, &canceled),
               rviz_mesh_plugin::Canceled);
}
