#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <osmesa_harness/render_fixture.h>

#include "level_of_detail/mesh_layout.h"
#include "rendering/gpu_mesh.h"
#include "rendering/mesh_visual.h"

/// Layouts made by hand, so that tests know every vertex, part and level.
namespace test_layouts {

using namespace rviz_mesh_plugin;

inline double flat(double, double)
{
  return 0.0;
}

/// @a cells x @a cells squares of two faces over [-1, 1]², row by row, counter-clockwise from
/// above; normals point up.
template <class Height>
std::shared_ptr<MeshData> grid(std::uint32_t cells, const Height& height)
{
  auto mesh = std::make_shared<MeshData>();
  mesh->uuid = "mesh";
  mesh->frame_id = "map";
  mesh->lower = {-1, -1, 1e9f};
  mesh->upper = {1, 1, -1e9f};
  for (std::uint32_t row = 0; row <= cells; ++row) {
    for (std::uint32_t column = 0; column <= cells; ++column) {
      MeshVertex vertex;
      const double x = -1.0 + 2.0 * column / cells;
      const double y = -1.0 + 2.0 * row / cells;
      const double dx = (height(x + 1e-4, y) - height(x - 1e-4, y)) / 2e-4;
      const double dy = (height(x, y + 1e-4) - height(x, y - 1e-4)) / 2e-4;
      const double length = std::sqrt(1.0 + dx * dx + dy * dy);
      vertex.position = {static_cast<float>(x), static_cast<float>(y),
                         static_cast<float>(height(x, y))};
      vertex.normal = {static_cast<float>(-dx / length), static_cast<float>(-dy / length),
                       static_cast<float>(1.0 / length)};
      mesh->lower[2] = std::min(mesh->lower[2], vertex.position[2]);
      mesh->upper[2] = std::max(mesh->upper[2], vertex.position[2]);
      mesh->vertices.push_back(vertex);
    }
  }
  for (std::uint32_t row = 0; row < cells; ++row) {
    for (std::uint32_t column = 0; column < cells; ++column) {
      const std::uint32_t a = row * (cells + 1) + column;
      for (const std::uint32_t i : {a, a + 1, a + cells + 2, a, a + cells + 2, a + cells + 1}) {
        mesh->indices.push_back(i);
      }
    }
  }
  return mesh;
}

inline std::vector<std::uint32_t> iota(std::size_t count)
{
  std::vector<std::uint32_t> values(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    values[i] = i;
  }
  return values;
}

/// One part, one level, everything as in the mesh.
inline std::shared_ptr<MeshLayout> simple(const MeshDataConstPtr& mesh)
{
  auto layout = std::make_shared<MeshLayout>();
  layout->mesh = mesh;
  layout->vertices = mesh->vertices;
  layout->sources = iota(mesh->vertexCount());
  layout->indices = mesh->indices;
  layout->cell_sizes = {0.0f};
  MeshPart part;
  part.lower = mesh->lower;
  part.upper = mesh->upper;
  part.levels = {{0, static_cast<std::uint32_t>(mesh->indices.size())}};
  layout->parts = {part};
  return layout;
}

/// A grid() cut into @a tiles x @a tiles parts, each with the levels 1, 2, 4 … cells a step.
inline std::shared_ptr<MeshLayout> tiled(const MeshDataConstPtr& mesh, std::uint32_t cells,
                                         std::uint32_t tiles, std::size_t level_count)
{
  auto layout = simple(mesh);
  layout->indices.clear();
  layout->cell_sizes.resize(level_count);
  const std::uint32_t size = cells / tiles;
  layout->parts.assign(tiles * tiles, layout->parts[0]);
  for (std::size_t level = level_count; level-- > 0;) {
    const std::uint32_t step = 1u << level;
    layout->cell_sizes[level] = level == 0 ? 0.0f : 2.0f * step / cells;
    for (std::uint32_t tile = 0; tile < tiles * tiles; ++tile) {
      MeshPart& part = layout->parts[tile];
      const std::uint32_t left = tile % tiles * size;
      const std::uint32_t bottom = tile / tiles * size;
      part.levels.resize(level_count);
      part.levels[level].start = static_cast<std::uint32_t>(layout->indices.size());
      for (std::uint32_t row = bottom; row < bottom + size; row += step) {
        for (std::uint32_t column = left; column < left + size; column += step) {
          const std::uint32_t a = row * (cells + 1) + column;
          const std::uint32_t c = a + step * (cells + 1);
          for (const std::uint32_t i : {a, a + step, c + step, a, c + step, c}) {
            layout->indices.push_back(i);
          }
        }
      }
      part.levels[level].count =
          static_cast<std::uint32_t>(layout->indices.size()) - part.levels[level].start;
      part.lower = {-1.0f + 2.0f * left / cells, -1.0f + 2.0f * bottom / cells, mesh->lower[2]};
      part.upper = {-1.0f + 2.0f * (left + size) / cells, -1.0f + 2.0f * (bottom + size) / cells,
                    mesh->upper[2]};
    }
  }
  return layout;
}

/// Each face has its own vertices, the last of which tells its color.
inline std::shared_ptr<MeshLayout> byFace(const MeshDataConstPtr& mesh)
{
  auto layout = simple(mesh);
  layout->split = Split::BY_FACE;
  layout->vertices.clear();
  layout->sources.clear();
  for (std::uint32_t i = 0; i < mesh->indices.size(); ++i) {
    layout->vertices.push_back(mesh->vertices[mesh->indices[i]]);
    layout->sources.push_back(i / 3);
  }
  layout->indices = iota(mesh->indices.size());
  return layout;
}

/// Two faces of each square have a material of their own, in the order of the squares; squares
/// beyond the last material have none. Textures cover each square once.
inline std::shared_ptr<MeshLayout> byMaterial(const MeshDataConstPtr& mesh,
                                              const std::vector<Material>& values)
{
  auto materials = std::make_shared<Materials>();
  materials->uuid = mesh->uuid;
  materials->materials = values;
  auto layout = byFace(mesh);
  layout->split = Split::BY_MATERIAL;
  layout->sources = mesh->indices;
  layout->parts.clear();
  const std::array<float, 2> corners[] = {{0, 1}, {1, 1}, {1, 0}, {0, 1}, {1, 0}, {0, 0}};
  for (std::uint32_t square = 0; square < mesh->faceCount() / 2; ++square) {
    MeshPart part;
    part.lower = mesh->lower;
    part.upper = mesh->upper;
    part.material = square < values.size() ? square : NONE;
    part.levels = {{6 * square, 6}};
    layout->parts.push_back(part);
    layout->texture_coordinates.insert(layout->texture_coordinates.end(), corners, corners + 6);
  }
  layout->materials = materials;
  return layout;
}

}  // namespace test_layouts

/// A MeshVisual of its own, without any display.
class VisualFixture : public osmesa_harness::RenderFixture
{
 protected:
  using Image = osmesa_harness::Image;
  using Rgb = osmesa_harness::Rgb;
  static constexpr Rgb BACKGROUND{48, 48, 48};

  void SetUp() override
  {
    osmesa_harness::RenderFixture::SetUp();
    parent = sceneManager()->getRootSceneNode()->createChildSceneNode();
    // Programs that all meshes share exist from here on.
    makeVisual();
    visual->setLayout(test_layouts::simple(test_layouts::grid(1, test_layouts::flat)));
    grab();
    visual.reset();
    empty = counts();
    makeVisual();
  }

  void TearDown() override
  {
    visual.reset();
    if (parent) {
      sceneManager()->destroySceneNode(parent);
    }
    osmesa_harness::RenderFixture::TearDown();
  }

  void makeVisual() { visual = std::make_unique<rviz_mesh_plugin::MeshVisual>(parent); }

  /// Uploads all that there is, one slice at a time; how many slices.
  std::size_t uploadAll()
  {
    std::size_t slices = 0;
    while (!visual->upload(std::chrono::microseconds(0))) {
      ++slices;
    }
    return slices;
  }

  void draw(const std::shared_ptr<rviz_mesh_plugin::MeshLayout>& layout)
  {
    visual->setLayout(layout);
    uploadAll();
  }

  /// From above, 100 pixels a meter: [-1, 1]² covers columns 220..419 and rows 140..339.
  Image picture(double pixels_per_meter = 100.0)
  {
    viewFromAbove(0.0, 0.0, pixels_per_meter);
    return grab();
  }

  static rviz_mesh_plugin::ColorSource colorsOf(std::vector<rviz_mesh_plugin::Rgba8> values)
  {
    return [values = std::move(values)](const std::uint32_t* sources, std::size_t count,
                                        rviz_mesh_plugin::Rgba8* colors) {
      for (std::size_t i = 0; i < count; ++i) {
        colors[i] = values.at(sources[i]);
      }
    };
  }

  Ogre::SceneNode* parent = nullptr;
  std::unique_ptr<rviz_mesh_plugin::MeshVisual> visual;
  rviz_mesh_plugin::MeshStyle style;
  osmesa_harness::SceneCounts empty;
};
