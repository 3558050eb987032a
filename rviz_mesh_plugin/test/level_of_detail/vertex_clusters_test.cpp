#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "level_of_detail/vertex_clusters.h"
#include "mesh_zoo.h"

namespace {

using rviz_mesh_plugin::clusterVertices;
using rviz_mesh_plugin::mainRegion;
using rviz_mesh_plugin::MeshData;
using rviz_mesh_plugin::MeshRegion;

using Face = std::array<std::uint32_t, 3>;
using Cell = std::array<std::uint32_t, 3>;

std::set<Face> facesOf(const std::vector<std::uint32_t>& indices)
{
  std::set<Face> faces;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    Face face{indices[i], indices[i + 1], indices[i + 2]};
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    faces.insert(face);
  }
  return faces;
}

/// The same by sets and maps.
std::set<Face> bruteForce(const MeshData& mesh, const MeshRegion& region, int cells)
{
  const float scale = cells / region.extent();
  const auto cellOf = [&](std::uint32_t vertex, std::size_t axis) {
    const float place = (mesh.vertices[vertex].position[axis] - region.lower[axis]) * scale;
    const float side = (region.upper[axis] - region.lower[axis]) * scale;
    return std::min(static_cast<std::uint32_t>(place), static_cast<std::uint32_t>(side));
  };
  std::map<Cell, std::pair<float, std::uint32_t>> middles;
  std::vector<Cell> of_vertices;
  for (std::uint32_t i = 0; i < mesh.vertexCount(); ++i) {
    const Cell cell{cellOf(i, 0), cellOf(i, 1), cellOf(i, 2)};
    of_vertices.push_back(cell);
    if (region.contains(mesh.vertices[i].position)) {
      float sum = 0.0f;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float off = (mesh.vertices[i].position[axis] - region.lower[axis]) * scale -
                          static_cast<float>(cell[axis]) - 0.5f;
        sum += off * off;
      }
      const auto found = middles.find(cell);
      if (found == middles.end() || sum < found->second.first) {
        middles[cell] = {sum, i};
      }
    }
  }
  std::vector<std::uint32_t> indices;
  for (std::size_t face = 0; face < mesh.faceCount(); ++face) {
    const std::uint32_t* corner = mesh.indices.data() + 3 * face;
    const bool inside = std::all_of(corner, corner + 3, [&](std::uint32_t vertex) {
      return region.contains(mesh.vertices[vertex].position);
    });
    const std::set<Cell> touched{of_vertices[corner[0]], of_vertices[corner[1]],
                                 of_vertices[corner[2]]};
    for (std::size_t i = 0; i < 3 && (!inside || touched.size() == 3); ++i) {
      indices.push_back(inside ? middles.at(of_vertices[corner[i]]).second : corner[i]);
    }
  }
  return facesOf(indices);
}

TEST(VertexClusters, are_those_of_brute_force)
{
  for (const auto& [name, mesh] : mesh_zoo::all()) {
    const MeshRegion region = mainRegion(*mesh);
    if (region.hasExtent()) {
      for (const int cells : {1, 7, 60}) {
        SCOPED_TRACE(name + " in " + std::to_string(cells) + " cells");
        const auto indices = clusterVertices(*mesh, region, cells);
        const std::set<Face> faces = facesOf(indices);
        EXPECT_EQ(faces, bruteForce(*mesh, region, cells));
        if (region.whole) {
          EXPECT_EQ(3 * faces.size(), indices.size()) << "a face is there twice";
        }
      }
    }
  }
}

TEST(VertexClusters, of_cells_smaller_than_edges_change_nothing)
{
  const auto mesh = mesh_zoo::shuffled(mesh_zoo::terrain(40, 40));
  const MeshRegion region = mainRegion(*mesh);
  ASSERT_TRUE(region.whole);
  EXPECT_EQ(facesOf(clusterVertices(*mesh, region, 400)), facesOf(mesh->indices));
}

}  // namespace
