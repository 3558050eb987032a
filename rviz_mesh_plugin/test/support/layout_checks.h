#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "level_of_detail/mesh_layout.h"

/// What every layout has to fulfil.
namespace layout_checks {

using namespace rviz_mesh_plugin;
using Position = std::array<float, 3>;

/// Without meshoptimizer there are no levels of detail.
constexpr bool canSimplify()
{
#ifdef HAVE_MESHOPTIMIZER
  return true;
#else
  return false;
#endif
}

template <class T>
std::array<T, 3> rotatedToLeast(const std::array<T, 3>& face)
{
  return std::min({face, {face[1], face[2], face[0]}, {face[2], face[0], face[1]}});
}

inline bool sameBits(const MeshVertex& a, const MeshVertex& b)
{
  return std::memcmp(&a, &b, sizeof(MeshVertex)) == 0;
}

/// The faces of one level by what @a value gives for each of their vertices, sorted; those that
/// turn round the same way are the same.
template <class Value>
auto facesOf(const MeshLayout& layout, std::size_t level, const Value& value)
{
  std::vector<std::array<decltype(value(std::uint32_t())), 3>> faces;
  for (const MeshPart& part : layout.parts) {
    const IndexRange& range = part.levels[level];
    for (std::size_t i = range.start; i < range.start + range.count; i += 3) {
      faces.push_back(rotatedToLeast<decltype(value(std::uint32_t()))>(
          {value(layout.indices[i]), value(layout.indices[i + 1]), value(layout.indices[i + 2])}));
    }
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

inline auto positionsOf(const MeshLayout& layout, std::size_t level)
{
  return facesOf(layout, level, [&](std::uint32_t i) { return layout.vertices[i].position; });
}

inline std::vector<std::uint32_t> materialsOfFaces(const MeshLayout& layout)
{
  std::vector<std::uint32_t> of_face(layout.mesh->faceCount(), NONE);
  for (std::size_t i = 0; i < layout.materials->faces.size(); ++i) {
    of_face[layout.materials->faces[i]] = layout.materials->face_materials[i];
  }
  return of_face;
}

/// The ranges follow each other, the coarsest level first, and cover all indices.
inline void expectRangesInOrder(const MeshLayout& layout)
{
  std::size_t next = 0;
  for (std::size_t level = layout.cell_sizes.size(); level-- > 0;) {
    for (const MeshPart& part : layout.parts) {
      ASSERT_EQ(part.levels.size(), layout.cell_sizes.size());
      ASSERT_EQ(part.levels[level].start, next);
      ASSERT_EQ(part.levels[level].count % 3, 0u);
      ASSERT_EQ(part.levels[level].seam_count % 3, 0u);
      ASSERT_TRUE(level > 0 || part.levels[level].seam_count == 0);
      next = part.levels[level].end();
    }
  }
  EXPECT_EQ(next, layout.indices.size());
  EXPECT_TRUE(std::is_sorted(layout.cell_sizes.begin(), layout.cell_sizes.end()));
}

inline void expectFacesInBoxes(const MeshLayout& layout)
{
  for (const MeshPart& part : layout.parts) {
    EXPECT_GT(part.levels[0].count, 0u);
    EXPECT_LE(part.levels[0].count, 3 * PART_FACES);
    for (const IndexRange& range : part.levels) {
      for (std::size_t i = range.start; i < range.end(); ++i) {
        ASSERT_LT(layout.indices[i], layout.vertices.size());
        if (i >= std::size_t{range.start} + range.count) {
          continue;  // seams reach out
        }
        const Position& position = layout.vertices[layout.indices[i]].position;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          ASSERT_LE(part.lower[axis], position[axis]);
          ASSERT_GE(part.upper[axis], position[axis]);
          ASSERT_GE(part.lower[axis], layout.mesh->lower[axis]);
          ASSERT_LE(part.upper[axis], layout.mesh->upper[axis]);
        }
      }
    }
  }
}

/// Vertices are vertices of the mesh, and the full level has the faces of the mesh.
inline void expectTheMesh(const MeshLayout& layout)
{
  const MeshData& mesh = *layout.mesh;
  for (std::size_t i = 0; i < layout.vertices.size(); ++i) {
    ASSERT_LT(layout.sources[i], mesh.vertexCount());
    ASSERT_TRUE(sameBits(layout.vertices[i], mesh.vertices[layout.sources[i]]));
  }
  std::vector<std::array<std::uint32_t, 3>> expected;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    expected.push_back(
        rotatedToLeast<std::uint32_t>({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]}));
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_TRUE(facesOf(layout, 0, [&](std::uint32_t i) { return layout.sources[i]; }) == expected);
}

/// The last vertex of each face is its own and tells which face of the mesh it is.
inline void expectFacesOfTheirOwn(const MeshLayout& layout)
{
  const MeshData& mesh = *layout.mesh;
  std::vector<int> seen(mesh.faceCount(), 0);
  std::set<std::uint32_t> last_vertices;
  for (const MeshPart& part : layout.parts) {
    for (std::size_t i = part.levels[0].start; i < part.levels[0].start + part.levels[0].count;
         i += 3) {
      const std::uint32_t face = layout.sources[layout.indices[i + 2]];
      ASSERT_LT(face, mesh.faceCount());
      ++seen[face];
      EXPECT_TRUE(last_vertices.insert(layout.indices[i + 2]).second);
      std::array<Position, 3> corners;
      std::array<Position, 3> expected;
      for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = layout.vertices[layout.indices[i + k]].position;
        expected[k] = mesh.vertices[mesh.indices[3 * face + k]].position;
      }
      ASSERT_EQ(rotatedToLeast(corners), rotatedToLeast(expected));
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
  for (const std::uint32_t source : layout.sources) {
    ASSERT_LT(source, mesh.faceCount());
  }
}

/// Each part has the material of its faces, and no vertex is used for two materials.
inline void expectMaterialsApart(const MeshLayout& layout)
{
  const auto of_face = materialsOfFaces(layout);
  std::map<std::array<std::uint32_t, 3>, std::multiset<std::uint32_t>> expected;
  for (std::size_t i = 0; i < of_face.size(); ++i) {
    const std::uint32_t* corners = &layout.mesh->indices[3 * i];
    expected[rotatedToLeast<std::uint32_t>({corners[0], corners[1], corners[2]})].insert(
        of_face[i]);
  }
  std::vector<std::int64_t> used_for(layout.vertices.size(), -1);
  for (const MeshPart& part : layout.parts) {
    for (std::size_t level = 0; level < part.levels.size(); ++level) {
      const IndexRange& range = part.levels[level];
      for (std::size_t i = range.start; i < range.end(); ++i) {
        const std::uint32_t vertex = layout.indices[i];
        ASSERT_TRUE(used_for[vertex] == -1 || used_for[vertex] == part.material);
        used_for[vertex] = part.material;
        if (level == 0 && !layout.texture_coordinates.empty()) {
          ASSERT_EQ(layout.texture_coordinates[vertex],
                    layout.materials->texture_coordinates[layout.sources[vertex]]);
        }
        if (level == 0 && i % 3 == range.start % 3) {
          auto& materials = expected[rotatedToLeast<std::uint32_t>(
              {layout.sources[vertex], layout.sources[layout.indices[i + 1]],
               layout.sources[layout.indices[i + 2]]})];
          const auto found = materials.find(part.material);
          ASSERT_NE(found, materials.end());
          materials.erase(found);
        }
      }
    }
  }
  EXPECT_EQ(layout.texture_coordinates.size(),
            layout.materials->texture_coordinates.empty() ? 0 : layout.vertices.size());
}

inline void expectSound(const MeshLayout& layout)
{
  EXPECT_EQ(layout.sources.size(), layout.vertices.size());
  EXPECT_EQ(layout.cell_sizes.front(), 0.0f);
  EXPECT_LE(2 * layout.indices.size(), 3 * layout.mesh->indices.size())
      << "the levels take more than half of the mesh";
  expectRangesInOrder(layout);
  expectFacesInBoxes(layout);
  if (layout.split == Split::BY_FACE) {
    expectFacesOfTheirOwn(layout);
  } else {
    expectTheMesh(layout);
  }
  if (layout.split == Split::BY_MATERIAL) {
    expectMaterialsApart(layout);
  }
}

}  // namespace layout_checks
