#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <thread>

#include "mesh_zoo.h"
#include "support/layout_checks.h"

using namespace rviz_mesh_plugin;
using layout_checks::canSimplify;
using layout_checks::expectSound;
using layout_checks::positionsOf;

namespace {

const std::atomic<bool> NOT_CANCELED{false};

MeshLayoutConstPtr layOutNow(const MeshDataConstPtr& mesh, Split split,
                             const MaterialsConstPtr& materials = nullptr)
{
  return layOut(mesh, split, materials, NOT_CANCELED);
}

/// Squares of materials as long as this, by the first corner; every seventh face has none.
std::shared_ptr<Materials> tiles(const MeshData& mesh, float length, bool textured)
{
  auto materials = std::make_shared<Materials>();
  materials->uuid = mesh.uuid;
  materials->materials.resize(16);
  for (std::uint32_t i = 0; i < mesh.faceCount(); ++i) {
    const auto& position = mesh.vertices[mesh.indices[3 * i]].position;
    if (i % 7 != 0) {
      materials->faces.push_back(i);
      const auto tile = [&](std::size_t axis) {
        return static_cast<std::uint32_t>(
            std::fmod((position[axis] - mesh.lower[axis]) / length, 4.0f));
      };
      materials->face_materials.push_back(std::min(tile(0), 3u) + 4 * std::min(tile(1), 3u));
    }
  }
  if (textured) {
    for (const auto& vertex : mesh.vertices) {
      materials->texture_coordinates.push_back({vertex.position[0], vertex.position[1]});
    }
  }
  return materials;
}

float distanceToNearest(const layout_checks::Position& position,
                        const std::vector<layout_checks::Position>& others)
{
  float least = std::numeric_limits<float>::max();
  for (const auto& other : others) {
    least = std::min(
        least, std::hypot(position[0] - other[0], position[1] - other[1], position[2] - other[2]));
  }
  return least;
}

/// Seen from above, in square meters; faces that lie on their backs count negative.
double areaFromAbove(const MeshLayout& layout, std::size_t level)
{
  double area = 0.0;
  for (const auto& face : positionsOf(layout, level)) {
    area += 0.5 * ((face[1][0] - face[0][0]) * (face[2][1] - face[0][1]) -
                   (face[2][0] - face[0][0]) * (face[1][1] - face[0][1]));
  }
  return area;
}

double sumOfBoxesFromAbove(const MeshLayout& layout)
{
  double area = 0.0;
  for (const MeshPart& part : layout.parts) {
    area += double(part.upper[0] - part.lower[0]) * (part.upper[1] - part.lower[1]);
  }
  return area;
}

}  // namespace

TEST(Layout, is_sound_for_meshes_of_all_kinds)
{
  for (const auto& [name, mesh] : mesh_zoo::all()) {
    SCOPED_TRACE(name);
    expectSound(*layOutNow(mesh, Split::NONE));
    expectSound(*layOutNow(mesh, Split::BY_FACE));
    for (const bool textured : {false, true}) {
      const auto materials = tiles(*mesh, 0.5f, textured);
      expectSound(*layOutNow(mesh, Split::BY_MATERIAL, materials));
    }
    expectSound(*layOutNow(mesh, Split::BY_MATERIAL, std::make_shared<Materials>()));
  }
}

TEST(Layout, keeps_what_it_has_been_made_of)
{
  const auto mesh = mesh_zoo::terrain(10, 10);
  const auto materials = tiles(*mesh, 0.5f, true);
  const auto layout = layOutNow(mesh, Split::BY_MATERIAL, materials);
  EXPECT_EQ(layout->mesh, mesh);
  EXPECT_EQ(layout->materials, materials);
  EXPECT_EQ(layout->split, Split::BY_MATERIAL);
  EXPECT_FALSE(layout->preview);
  EXPECT_EQ(layOutNow(mesh, Split::NONE, materials)->materials, nullptr);
}

TEST(Layout, leaves_out_what_is_hidden)
{
  for (const auto& [name, mesh] : mesh_zoo::all()) {
    SCOPED_TRACE(name);
    FaceBits some(mesh->faceCount());
    FaceBits all = some;
    all.addAll();
    std::vector<std::uint32_t> shown;
    auto rest = std::make_shared<MeshData>(*mesh);  // of the shown faces alone
    rest->indices.clear();
    for (std::uint32_t face = 0; face < mesh->faceCount(); ++face) {
      if (face % 5 < 2 || face > 2 * mesh->faceCount() / 3) {
        some.add(FaceBits::Faces{face});
      } else {
        shown.push_back(face);
        const auto corners = mesh->indices.begin() + 3 * static_cast<std::ptrdiff_t>(face);
        rest->indices.insert(rest->indices.end(), corners, corners + 3);
      }
    }
    const auto hidden = std::make_shared<const HiddenFaces>(some);
    const auto materials = tiles(*mesh, 0.5f, true);
    for (const Split split : {Split::NONE, Split::BY_FACE, Split::BY_MATERIAL}) {
      const auto layout = layOut(mesh, split, materials, NOT_CANCELED, hidden);
      const auto alone = layOutNow(rest, Split::NONE);
      EXPECT_EQ(layout->mesh, mesh);
      EXPECT_EQ(layout->hidden, hidden);
      EXPECT_EQ(positionsOf(*layout, 0), positionsOf(*alone, 0));
      if (split == Split::BY_FACE) {  // each face has the color of that face
        std::vector<std::uint32_t> sources = layout->sources;
        std::sort(sources.begin(), sources.end());
        sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
        EXPECT_TRUE(std::includes(sources.begin(), sources.end(), shown.begin(), shown.end()));
      } else {
        const auto sourceOf = [&](std::uint32_t i) { return layout->sources[i]; };
        const auto aloneOf = [&](std::uint32_t i) { return alone->sources[i]; };
        EXPECT_EQ(layout_checks::facesOf(*layout, 0, sourceOf),
                  layout_checks::facesOf(*alone, 0, aloneOf));
      }
      if (split == Split::NONE) {
        std::vector<std::uint32_t> faces = *layout->faces;
        std::sort(faces.begin(), faces.end());
        EXPECT_EQ(faces, shown);
      }
      const auto none =
          layOut(mesh, split, materials, NOT_CANCELED, std::make_shared<const HiddenFaces>(all));
      EXPECT_TRUE(none->parts.empty());
      EXPECT_TRUE(none->indices.empty());
    }
  }
}

/// Each face has the material that it has in the mesh.
TEST(Layout, keeps_the_materials_of_what_is_not_hidden)
{
  const auto mesh = mesh_zoo::terrain(40, 40);
  const auto materials = tiles(*mesh, 0.5f, true);
  FaceBits some(mesh->faceCount());
  for (std::uint32_t face = 0; face < mesh->faceCount(); face += 3) {
    some.add(FaceBits::Faces{face});
  }
  const auto layout = layOut(mesh, Split::BY_MATERIAL, materials, NOT_CANCELED,
                             std::make_shared<const HiddenFaces>(some));
  std::map<std::vector<std::uint32_t>, std::uint32_t> expected;  // by corners
  const auto of_face = layout_checks::materialsOfFaces(*layout);
  for (std::uint32_t face = 0; face < mesh->faceCount(); ++face) {
    const auto corners = mesh->indices.begin() + 3 * static_cast<std::ptrdiff_t>(face);
    std::vector<std::uint32_t> sorted(corners, corners + 3);
    std::sort(sorted.begin(), sorted.end());
    expected[sorted] = of_face[face];
  }
  std::size_t seen = 0;
  for (const MeshPart& part : layout->parts) {
    const IndexRange& range = part.levels[0];
    for (std::size_t i = range.start; i < range.start + range.count; i += 3, ++seen) {
      std::vector<std::uint32_t> corners;
      for (std::size_t k = i; k < i + 3; ++k) {
        corners.push_back(layout->sources[layout->indices[k]]);
      }
      std::sort(corners.begin(), corners.end());
      EXPECT_EQ(part.material, expected.at(corners));
    }
  }
  EXPECT_EQ(seen, mesh->faceCount() - some.count());
}

TEST(Layout, has_as_few_vertices_as_its_split_allows)
{
  const auto mesh = mesh_zoo::terrain(150, 200);
  EXPECT_EQ(layOutNow(mesh, Split::NONE)->vertices.size(), mesh->vertexCount());
  EXPECT_LE(layOutNow(mesh, Split::BY_FACE)->vertices.size(), mesh->vertexCount() * 21 / 10);
  EXPECT_EQ(layOutNow(mesh, Split::BY_MATERIAL, std::make_shared<Materials>())->vertices.size(),
            mesh->vertexCount());
}

TEST(Layout, has_parts_with_small_boxes)
{
  const auto mesh = mesh_zoo::shuffled(mesh_zoo::terrain(500, 400));
  const auto layout = layOutNow(mesh, Split::NONE);
  const std::size_t least = mesh->faceCount() / PART_FACES;
  EXPECT_GT(layout->parts.size(), least);
  if (canSimplify()) {
    EXPECT_LE(layout->parts.size(), 3 * least);
    EXPECT_LT(sumOfBoxesFromAbove(*layout), 4.0 * 50.0 * 40.0);
  }
}

TEST(Layout, keeps_strays_out_of_the_parts)
{
  const auto mesh = mesh_zoo::changed(mesh_zoo::terrain(300, 300), [](MeshData& changed) {
    changed.vertices[45000].position = {1000.0f, -1000.0f, 1000.0f};
  });
  const auto layout = layOutNow(mesh, Split::NONE);
  EXPECT_EQ(layout->cell_sizes.size() > 2, canSimplify());
  if (canSimplify()) {
    std::size_t with_stray = 0;
    std::size_t faces_with_stray = 0;
    for (const MeshPart& part : layout->parts) {
      if (part.upper[0] - part.lower[0] > 100.0f) {
        ++with_stray;
        faces_with_stray += part.levels[0].count / 3;
      }
    }
    EXPECT_GE(with_stray, 1u);
    EXPECT_LE(with_stray, 6u) << "the vertex has six faces";
    EXPECT_LT(faces_with_stray, 1000u);
  }
}

TEST(Layout, has_levels_that_stay_near_to_the_mesh_and_have_no_holes)
{
  const auto mesh = mesh_zoo::terrain(150, 200);
  const auto layout = layOutNow(mesh, Split::NONE);
  ASSERT_EQ(layout->cell_sizes.size() > 2, canSimplify());
  const double area = areaFromAbove(*layout, 0);
  float moved = 0.0f;
  for (std::size_t level = 1; level < layout->cell_sizes.size(); ++level) {
    SCOPED_TRACE(layout->cell_sizes[level]);
    moved += std::sqrt(3.0f) * layout->cell_sizes[level];
    std::vector<layout_checks::Position> corners;
    for (const auto& face : positionsOf(*layout, level)) {
      corners.insert(corners.end(), face.begin(), face.end());
    }
    for (std::size_t i = 0; i < mesh->vertexCount(); i += 17) {
      ASSERT_LE(distanceToNearest(mesh->vertices[i].position, corners), 1.01f * moved);
    }
    // The outline is drawn in by half a cell or so.
    const double outline = 2.0 * (15.0 + 20.0) * layout->cell_sizes[level];
    EXPECT_NEAR(areaFromAbove(*layout, level), area, outline);
  }
}

TEST(Layout, by_material_and_by_face_have_the_same_simplified_faces)
{
  const auto mesh = mesh_zoo::terrain(150, 200);
  const auto layout = layOutNow(mesh, Split::NONE);
  for (const float length : {0.15f, 1.0f, 4.0f}) {
    const auto by_material =
        layOutNow(mesh, Split::BY_MATERIAL, tiles(*mesh, length, length == 1.0f));
    EXPECT_EQ(by_material->cell_sizes, layout->cell_sizes);
    const auto by_face = layOutNow(mesh, Split::BY_FACE);
    EXPECT_EQ(by_face->cell_sizes, layout->cell_sizes);
    for (std::size_t level = 0; level < layout->cell_sizes.size(); ++level) {
      EXPECT_TRUE(positionsOf(*by_material, level) == positionsOf(*layout, level))
          << "a crack between materials, tiles of " << length << " m, level " << level;
      EXPECT_TRUE(positionsOf(*by_face, level) == positionsOf(*layout, level));
    }
  }
}

TEST(Layout, gives_simplified_faces_the_color_of_a_face_nearby)
{
  const auto mesh = mesh_zoo::terrain(150, 200);
  const auto layout = layOutNow(mesh, Split::BY_FACE);
  for (const MeshPart& part : layout->parts) {
    for (std::size_t level = 1; level < part.levels.size(); ++level) {
      const IndexRange& range = part.levels[level];
      for (std::size_t i = range.start + 2; i < range.start + range.count; i += 3) {
        const auto& corner = layout->vertices[layout->indices[i]].position;
        const std::uint32_t* face = &mesh->indices[3 * layout->sources[layout->indices[i]]];
        ASSERT_LE(distanceToNearest(
                      corner, {mesh->vertices[face[0]].position, mesh->vertices[face[1]].position,
                               mesh->vertices[face[2]].position}),
                  0.0f);
      }
    }
  }
}

TEST(Layout, does_not_smear_textures_over_seams)
{
  for (const float jump : {0.5f, 100.0f}) {
    SCOPED_TRACE(jump);
    // Two halves of a plane, their common vertices twice, the halves apart in the texture.
    auto mesh = mesh_zoo::terrain(100, 100);
    const std::size_t seam = mesh->vertices.size();
    for (std::uint32_t row = 0; row <= 100; ++row) {
      mesh->vertices.push_back(MeshVertex(mesh->vertices[row * 101 + 50]));
    }
    auto materials = std::make_shared<Materials>();
    materials->materials.resize(1);
    materials->materials[0].texture_index = 0;
    for (std::uint32_t face = 0; face < mesh->faceCount(); ++face) {
      materials->faces.push_back(face);
      materials->face_materials.push_back(0);
      const bool right = face / 2 % 100 >= 50;
      for (std::size_t corner = 0; corner < 3 && right; ++corner) {
        std::uint32_t& index = mesh->indices[3 * face + corner];
        index = index % 101 == 50 ? static_cast<std::uint32_t>(seam + index / 101) : index;
      }
    }
    for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
      const auto& position = mesh->vertices[i].position;
      const bool right = i >= seam || i % 101 > 50;
      materials->texture_coordinates.push_back(
          {position[0] / 10.0f + (right ? jump : 0.0f), position[1] / 10.0f});
    }
    const auto layout = layOutNow(mesh, Split::BY_MATERIAL, materials);
    expectSound(*layout);
    ASSERT_EQ(layout->cell_sizes.size() > 1, canSimplify());
    // All corners of a face lie in one half, where they belong; hardly a face is of one color.
    std::size_t copies = 0;
    for (std::size_t i = 0; i < layout->indices.size(); i += 3) {
      std::array<float, 3> shifts;
      bool has_copy = false;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = layout->indices[i + corner];
        const float x = layout->vertices[vertex].position[0] / 10.0f;
        shifts[corner] = layout->texture_coordinates[vertex][0] - x;
        has_copy = has_copy || vertex >= mesh->vertices.size();
      }
      const auto range = std::minmax({shifts[0], shifts[1], shifts[2]});
      if (has_copy) {
        ++copies;
      } else {
        ASSERT_NEAR(range.first, range.second, 1e-4f) << "across the seam";
      }
    }
    EXPECT_LE(copies, layout->indices.size() / 3 / 1000);
  }
}

TEST(Layout, refuses_materials_of_another_mesh)
{
  const auto mesh = mesh_zoo::terrain(10, 10);
  EXPECT_THROW(layOutNow(mesh, Split::BY_MATERIAL), std::invalid_argument);
  const std::function<void(Materials&)> faults[] = {
      [](Materials& materials) { materials.faces.back() = 200; },
      [](Materials& materials) { materials.face_materials.front() = 16; },
      [](Materials& materials) { materials.texture_coordinates.pop_back(); }};
  for (const auto& fault : faults) {
    auto materials = tiles(*mesh, 0.5f, true);
    fault(*materials);
    EXPECT_THROW(layOutNow(mesh, Split::BY_MATERIAL, materials), std::invalid_argument);
  }
}

TEST(Layout, is_given_up_when_cancelled)
{
  const auto mesh = mesh_zoo::terrain(300, 300);
  std::atomic<bool> canceled{true};
  EXPECT_EQ(layOut(mesh, Split::NONE, nullptr, canceled), nullptr);
  for (int delay = 0; delay < 10; ++delay) {
    canceled = false;
    std::thread canceller([&]() {
      std::this_thread::sleep_for(std::chrono::milliseconds(delay));
      canceled = true;
    });
    const auto layout = layOut(mesh, Split::NONE, nullptr, canceled);
    canceller.join();
    if (layout) {
      expectSound(*layout);
    }
  }
}

TEST(Preview, is_a_small_part_of_the_mesh)
{
  const auto mesh = mesh_zoo::shuffled(mesh_zoo::terrain(720, 700));
  const auto preview = layOutPreview(mesh);
  ASSERT_NE(preview, nullptr);
  EXPECT_TRUE(preview->preview);
  EXPECT_EQ(preview->mesh, mesh);
  ASSERT_EQ(preview->cell_sizes.size(), 1u);
  EXPECT_NEAR(preview->cell_sizes[0], 0.45f, 0.01f);
  EXPECT_LT(preview->indices.size(), mesh->indices.size() / 5);
  EXPECT_GT(preview->indices.size(), 3u * 30000u);
  layout_checks::expectRangesInOrder(*preview);
  layout_checks::expectFacesInBoxes(*preview);
  for (std::size_t i = 0; i < preview->vertices.size(); ++i) {
    ASSERT_TRUE(layout_checks::sameBits(preview->vertices[i], mesh->vertices[preview->sources[i]]));
  }
  EXPECT_NEAR(areaFromAbove(*preview, 0), 72.0 * 70.0, 300.0 * 0.36);
}

TEST(Preview, is_left_out_where_it_would_show_nothing_or_save_nothing)
{
  for (const auto& [name, mesh] : mesh_zoo::all()) {
    const auto preview = layOutPreview(mesh);
    if (preview) {
      SCOPED_TRACE(name);
      EXPECT_GT(preview->indices.size(), 0u);
      EXPECT_LE(2 * preview->indices.size(), mesh->indices.size());
      layout_checks::expectFacesInBoxes(*preview);
    }
  }
}
