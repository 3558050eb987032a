#pragma once

#include <mesh_map/base/array_view.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

/// Meshes on which the spatial index is compared with looking at every face.
struct TestMesh
{
  std::string name;
  std::vector<float> positions;
  std::vector<std::uint32_t> faces;

  mesh_map::MeshView view() const { return {positions, faces}; }
  std::size_t faceCount() const { return faces.size() / 3; }
  const float* corner(std::size_t face, std::size_t k) const
  {
    return positions.data() + 3 * std::size_t{faces[3 * face + k]};
  }

  /// The 9 floats of a face.
  std::vector<float> corners(std::size_t face) const
  {
    std::vector<float> result;
    for (std::size_t k = 0; k < 3; ++k) {
      result.insert(result.end(), corner(face, k), corner(face, k) + 3);
    }
    return result;
  }
};

/// A rough surface of 2 cells^2 faces, shared vertices, moved by `offset`.
inline TestMesh terrain(unsigned cells, float size = 10.0f, float offset = 0.0f)
{
  TestMesh mesh{"terrain " + std::to_string(cells), {}, {}};
  for (unsigned i = 0; i <= cells; ++i) {
    for (unsigned j = 0; j <= cells; ++j) {
      const float x = size * i / cells, y = size * j / cells;
      const float z = 0.1f * size * std::sin(7.0f * x / size) * std::cos(5.0f * y / size) +
                      0.01f * size * std::sin(91.0f * x / size + 57.0f * y / size);
      mesh.positions.insert(mesh.positions.end(), {x + offset, y + offset, z + offset});
    }
  }
  for (unsigned i = 0; i < cells; ++i) {
    for (unsigned j = 0; j < cells; ++j) {
      const unsigned v = i * (cells + 1) + j;
      mesh.faces.insert(mesh.faces.end(),
                        {v, v + cells + 1, v + 1, v + 1, v + cells + 1, v + cells + 2});
    }
  }
  return mesh;
}

/// Triangles anywhere in a cube of edge 1, of any shape: edges about `edge` long.
inline TestMesh soup(unsigned count, float edge = 0.2f, unsigned seed = 0)
{
  TestMesh mesh{"soup " + std::to_string(count), {}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(0.0f, 1.0f);
  std::normal_distribution<float> side(0.0f, edge);
  for (unsigned i = 0; i < count; ++i) {
    const float center[3] = {place(random), place(random), place(random)};
    for (unsigned k = 0; k < 9; ++k) {
      mesh.positions.push_back(center[k % 3] + side(random));
    }
    for (unsigned k = 0; k < 3; ++k) {
      mesh.faces.push_back(3 * i + k);
    }
  }
  return mesh;
}

/// The surface of the cube from 0 to 1 in `cells` x `cells` squares a side: box planes everywhere.
inline TestMesh cube(unsigned cells)
{
  TestMesh mesh{"cube " + std::to_string(cells), {}, {}};
  for (unsigned side = 0; side < 6; ++side) {
    const unsigned axis = side / 2, base = static_cast<unsigned>(mesh.positions.size() / 3);
    for (unsigned i = 0; i <= cells; ++i) {
      for (unsigned j = 0; j <= cells; ++j) {
        float p[3] = {};
        p[axis] = static_cast<float>(side % 2);
        p[(axis + 1) % 3] = static_cast<float>(i) / cells;
        p[(axis + 2) % 3] = static_cast<float>(j) / cells;
        mesh.positions.insert(mesh.positions.end(), p, p + 3);
      }
    }
    for (unsigned i = 0; i < cells; ++i) {
      for (unsigned j = 0; j < cells; ++j) {
        const unsigned a = base + i * (cells + 1) + j, b = a + cells + 1;
        if (side % 2 == 1) {
          mesh.faces.insert(mesh.faces.end(), {a, b, a + 1, a + 1, b, b + 1});
        } else {
          mesh.faces.insert(mesh.faces.end(), {a, a + 1, b, a + 1, b + 1, b});
        }
      }
    }
  }
  return mesh;
}

/// The same triangle again and again.
inline TestMesh identical(unsigned count)
{
  TestMesh mesh{"identical " + std::to_string(count), {0, 0, 0, 1, 0, 0, 0, 1, 0}, {}};
  for (unsigned i = 0; i < count; ++i) {
    mesh.faces.insert(mesh.faces.end(), {0, 1, 2});
  }
  return mesh;
}

/// A mesh and one triangle a million times larger than it, below it.
inline TestMesh withGiant(TestMesh mesh)
{
  mesh.name += " and a giant";
  const auto v = static_cast<unsigned>(mesh.positions.size() / 3);
  mesh.positions.insert(mesh.positions.end(),
                        {-1e6f, -1e6f, -2.0f, 3e6f, -1e6f, -2.0f, -1e6f, 3e6f, -2.0f});
  mesh.faces.insert(mesh.faces.end(), {v, v + 1, v + 2});
  return mesh;
}

/// Needles, and triangles without area: points and segments.
inline TestMesh slivers()
{
  TestMesh mesh{"slivers", {}, {}};
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(0.0f, 1.0f);
  for (unsigned i = 0; i < 300; ++i) {
    const float a[3] = {place(random), place(random), place(random)};
    const float b[3] = {place(random), place(random), place(random)};
    const float thin = i % 3 == 0 ? 0.0f : 1e-6f;
    for (unsigned k = 0; k < 3; ++k) {
      mesh.faces.push_back(3 * i + k);
    }
    mesh.positions.insert(mesh.positions.end(), a, a + 3);
    mesh.positions.insert(mesh.positions.end(), i % 9 == 0 ? a : b, (i % 9 == 0 ? a : b) + 3);
    for (unsigned axis = 0; axis < 3; ++axis) {
      mesh.positions.push_back(0.5f * (a[axis] + b[axis]) + (axis == 2 ? thin : 0.0f));
    }
  }
  return mesh;
}

/// All of them, small enough for looking at every face.
inline std::vector<TestMesh> testMeshes()
{
  TestMesh one{"one triangle", {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}};
  TestMesh far = terrain(20, 10.0f, 1e6f);
  far.name = "terrain 1e6 m away";
  return {one,     terrain(1),      terrain(5), terrain(40),
          far,     soup(3),         soup(1000), soup(500, 2.0f),
          cube(4), identical(1000), slivers(),  withGiant(soup(300))};
}
