#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/mesh_data.h"

/// Meshes as they are found in the field, and worse.
namespace mesh_zoo {

using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::MeshDataConstPtr;
using MeshPtr = std::shared_ptr<MeshData>;

inline std::uint32_t addVertex(MeshData& mesh, float x, float y, float z)
{
  rviz_mesh_plugin::MeshVertex vertex;
  vertex.position = {x, y, z};
  vertex.normal = {0.0f, 0.0f, 1.0f};
  mesh.vertices.push_back(vertex);
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

inline void addFace(MeshData& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c)
{
  mesh.indices.insert(mesh.indices.end(), {a, b, c});
}

inline MeshPtr finish(MeshPtr mesh)
{
  mesh->uuid = "zoo";
  mesh->frame_id = "map";
  mesh->lower = mesh->upper = mesh->vertices.front().position;
  for (const auto& vertex : mesh->vertices) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      mesh->lower[axis] = std::min(mesh->lower[axis], vertex.position[axis]);
      mesh->upper[axis] = std::max(mesh->upper[axis], vertex.position[axis]);
    }
  }
  return mesh;
}

/// A wavy terrain of columns x rows squares of 0.1 m, its corner at an offset.
inline MeshPtr terrain(std::uint32_t columns, std::uint32_t rows, float scale = 1.0f,
                       float offset = 0.0f)
{
  auto mesh = std::make_shared<MeshData>();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> jitter(-0.02f, 0.02f);
  for (std::uint32_t y = 0; y <= rows; ++y) {
    for (std::uint32_t x = 0; x <= columns; ++x) {
      const float u = 0.1f * x + jitter(random);
      const float v = 0.1f * y + jitter(random);
      addVertex(*mesh, offset + scale * u, offset + scale * v,
                scale * (std::sin(u) + std::cos(0.7f * v)));
    }
  }
  for (std::uint32_t y = 0; y < rows; ++y) {
    for (std::uint32_t x = 0; x < columns; ++x) {
      const std::uint32_t corner = y * (columns + 1) + x;
      addFace(*mesh, corner, corner + 1, corner + columns + 2);
      addFace(*mesh, corner, corner + columns + 2, corner + columns + 1);
    }
  }
  return finish(mesh);
}

inline MeshPtr shuffled(MeshPtr mesh)
{
  std::mt19937 random(2);
  std::vector<std::uint32_t> places(mesh->vertices.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i] = static_cast<std::uint32_t>(i);
  }
  std::shuffle(places.begin(), places.end(), random);
  const auto vertices = mesh->vertices;
  for (std::size_t i = 0; i < places.size(); ++i) {
    mesh->vertices[places[i]] = vertices[i];
  }
  for (std::uint32_t& index : mesh->indices) {
    index = places[index];
  }
  return mesh;
}

/// Faces anywhere, joined with nothing.
inline MeshPtr soup(std::size_t faces, float size)
{
  auto mesh = std::make_shared<MeshData>();
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(0.0f, 10.0f);
  std::uniform_real_distribution<float> corner(0.0f, size);
  for (std::size_t i = 0; i < faces; ++i) {
    const float x = place(random);
    const float y = place(random);
    const float z = place(random);
    for (int k = 0; k < 3; ++k) {
      mesh->indices.push_back(
          addVertex(*mesh, x + corner(random), y + corner(random), z + corner(random)));
    }
  }
  return finish(mesh);
}

/// All faces share one vertex.
inline MeshPtr fan(std::uint32_t faces)
{
  auto mesh = std::make_shared<MeshData>();
  addVertex(*mesh, 0.0f, 0.0f, 0.0f);
  for (std::uint32_t i = 0; i <= faces; ++i) {
    addVertex(*mesh, std::cos(6.0f * i / faces), std::sin(6.0f * i / faces), 0.0f);
  }
  for (std::uint32_t i = 1; i <= faces; ++i) {
    addFace(*mesh, 0, i, i + 1);
  }
  return finish(mesh);
}

inline MeshPtr changed(MeshPtr mesh, const std::function<void(MeshData&)>& change)
{
  change(*mesh);
  return finish(mesh);
}

inline std::vector<std::pair<std::string, MeshDataConstPtr>> all()
{
  const auto move_all = [](float x, float y, float z) {
    return [x, y, z](MeshData& mesh) {
      for (auto& vertex : mesh.vertices) {
        vertex.position = {x, y, z};
      }
    };
  };
  const auto flatten = [](std::size_t axis) {
    return [axis](MeshData& mesh) {
      for (auto& vertex : mesh.vertices) {
        vertex.position[axis] = 2.0f;
      }
    };
  };
  return {
      {"one face", changed(terrain(1, 1), [](MeshData& mesh) { mesh.indices.resize(3); })},
      {"a square", terrain(1, 1)},
      {"a terrain", terrain(150, 200)},
      {"in random order", shuffled(terrain(150, 100))},
      {"a corridor", terrain(6000, 3)},
      {"a plane", changed(terrain(60, 60), flatten(2))},
      {"a line", changed(changed(terrain(60, 60), flatten(2)), flatten(0))},
      {"all in one place", changed(terrain(60, 60), move_all(1.0f, 2.0f, 3.0f))},
      {"tiny", terrain(60, 60, 1e-36f)},
      {"small", terrain(60, 60, 1e-6f)},
      {"huge", terrain(60, 60, 1e13f)},
      {"far off", terrain(60, 60, 1.0f, 1e6f)},
      {"with one vertex a kilometer off",
       changed(terrain(100, 100),
               [](MeshData& mesh) {
                 mesh.vertices[5000].position = {1000.0f, -1000.0f, 1000.0f};
               })},
      {"with unused vertices far off", changed(terrain(100, 100),
                                               [](MeshData& mesh) {
                                                 addVertex(mesh, 1e5f, 0.0f, 0.0f);
                                                 addVertex(mesh, 0.0f, -1e5f, 1e9f);
                                               })},
      {"with all faces twice", changed(terrain(60, 60),
                                       [](MeshData& mesh) {
                                         const auto indices = mesh.indices;
                                         mesh.indices.insert(mesh.indices.end(), indices.begin(),
                                                             indices.end());
                                       })},
      {"with faces that have no area", changed(terrain(60, 60),
                                               [](MeshData& mesh) {
                                                 for (std::uint32_t i = 0; i < 3000; ++i) {
                                                   addFace(mesh, i, i, i % 7 == 0 ? i : i + 1);
                                                 }
                                               })},
      {"in two places far from each other", changed(terrain(100, 100),
                                                    [](MeshData& mesh) {
                                                      for (std::size_t i = mesh.vertices.size() / 2;
                                                           i < mesh.vertices.size(); ++i) {
                                                        mesh.vertices[i].position[0] += 5000.0f;
                                                      }
                                                    })},
      {"a soup", soup(20000, 0.05f)},
      {"a dense soup", soup(5000, 5.0f)},
      {"a fan", fan(20000)},
      {"one face more than a part holds",
       changed(terrain(8193, 1), [](MeshData& mesh) { mesh.indices.resize(3 * 16385); })},
  };
}

}  // namespace mesh_zoo
