#pragma once

#include <mesh_map/distance/fast_marching/fast_marching_mesh.h>
#include <mesh_map/mesh/topology.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "test_meshes.h"

constexpr float FAR = std::numeric_limits<float>::infinity();

inline double between(const TestMesh& mesh, std::size_t u, std::size_t v)
{
  double sum = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double d = double{mesh.positions[3 * u + axis]} - mesh.positions[3 * v + axis];
    sum += d * d;
  }
  return std::sqrt(sum);
}

/// A mesh prepared for fronts.
struct FrontSample
{
  TestMesh mesh;
  mesh_map::Topology topology;
  std::shared_ptr<const mesh_map::FastMarchingMesh> front;

  explicit FrontSample(TestMesh given)
      : mesh(std::move(given)),
        topology(mesh_map::buildTopology(mesh.faces, mesh.positions.size() / 3)),
        front(std::make_shared<mesh_map::FastMarchingMesh>(
            mesh.view(), mesh_map::RowsView{topology.vertex_face_offsets, topology.vertex_faces}))
  {
  }

  std::size_t size() const { return mesh.positions.size() / 3; }

  double longestEdge() const
  {
    double longest = 0.0;
    for (std::size_t e = 0; e < topology.edgeCount(); ++e) {
      longest = std::max(longest, between(mesh, topology.edges[2 * e], topology.edges[2 * e + 1]));
    }
    return longest;
  }

  /// The most by which distances differ along an edge more than its length.
  double lipschitzExcess(mesh_map::ArrayView<float> distances) const
  {
    double worst = -1.0;
    for (std::size_t e = 0; e < topology.edgeCount(); ++e) {
      const std::uint32_t a = topology.edges[2 * e], b = topology.edges[2 * e + 1];
      if (distances[a] < FAR && distances[b] < FAR) {
        const double step = std::abs(double{distances[a]} - distances[b]);
        worst = std::max(worst, step - between(mesh, a, b));
      }
    }
    return worst;
  }
};

/// A square of `cells` x `cells` cells of 0.1 m, divided one way or the other, with vertices moved
/// by up to `jitter` of a cell.
inline TestMesh plane(unsigned cells, double jitter, unsigned seed = 1)
{
  TestMesh mesh{"plane", {}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> moved(-jitter, jitter);
  for (unsigned i = 0; i <= cells; ++i) {
    for (unsigned j = 0; j <= cells; ++j) {
      mesh.positions.push_back(static_cast<float>(0.1 * (i + moved(random))));
      mesh.positions.push_back(static_cast<float>(0.1 * (j + moved(random))));
      mesh.positions.push_back(0.0f);
    }
  }
  for (unsigned i = 0; i < cells; ++i) {
    for (unsigned j = 0; j < cells; ++j) {
      const unsigned a = i * (cells + 1) + j, b = a + cells + 1;
      if (random() % 2 == 0) {
        mesh.faces.insert(mesh.faces.end(), {a, b, a + 1, a + 1, b, b + 1});
      } else {
        mesh.faces.insert(mesh.faces.end(), {a, b, b + 1, a, b + 1, a + 1});
      }
    }
  }
  return mesh;
}

/// Faces of all kinds on few vertices: degenerate, duplicate, and edges of many faces.
inline TestMesh tangle(unsigned vertices, unsigned faces, unsigned seed)
{
  TestMesh mesh{"tangle", {}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(0.0f, 1.0f);
  for (unsigned i = 0; i < 3 * vertices; ++i) {
    mesh.positions.push_back(place(random));
  }
  for (unsigned i = 0; i < 3 * faces; ++i) {
    mesh.faces.push_back(static_cast<std::uint32_t>(random() % vertices));
  }
  return mesh;
}

inline std::vector<TestMesh> frontMeshes()
{
  std::vector<TestMesh> meshes = testMeshes();
  for (unsigned seed = 0; seed < 4; ++seed) {
    meshes.push_back(tangle(9, 25, seed));
    meshes.push_back(tangle(60, 300, seed));
    meshes.push_back(tangle(200, 150, seed));
  }
  meshes.push_back(plane(20, 0.3));
  return meshes;
}

inline std::vector<std::uint8_t> randomMask(std::size_t size, double share, unsigned seed)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  std::vector<std::uint8_t> mask(size);
  std::generate(mask.begin(), mask.end(), [&]() { return chance(random) < share ? 1 : 0; });
  return mask;
}
