#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "visual_fixture.h"

using osmesa_harness::imagesMatch;
using rviz_mesh_plugin::MeshLayout;
using rviz_mesh_plugin::MeshLayoutConstPtr;
using rviz_mesh_plugin::MeshStyle;
using rviz_mesh_plugin::Rgba8;
using rviz_mesh_plugin::Split;
using test_layouts::flat;
using test_layouts::grid;

namespace {

double hills(double x, double y)
{
  return 0.15 * std::sin(5 * x) * std::cos(4 * y);
}

std::size_t rangeCount(const MeshLayout& layout)
{
  std::set<std::uint32_t> starts;
  for (const auto& part : layout.parts) {
    for (const auto& range : part.levels) {
      if (range.end() > range.start) {
        starts.insert(range.start);
      }
    }
  }
  return starts.size();
}

}  // namespace

/// Meshes whose indices lie in several buffers look as those in one.
class VisualBuffers : public VisualFixture
{
 protected:
  struct View
  {
    const char* name;
    Point eye;
    bool level_of_detail;
  };

  /// Near and far parts at once; from far; all in full.
  static constexpr View VIEWS[] = {{"along", {-0.6, -0.6, 0.3}, true},
                                   {"far", {12.0, 9.0, 8.0}, true},
                                   {"middle", {2.0, 2.0, 1.5}, true},
                                   {"full", {2.0, 2.0, 1.5}, false}};

  void SetUp() override
  {
    VisualFixture::SetUp();
    const std::atomic<bool> go_on{false};
    mesh = grid(256, hills);
    layout = rviz_mesh_plugin::layOut(mesh, Split::NONE, nullptr, go_on);
    by_face = rviz_mesh_plugin::layOut(mesh, Split::BY_FACE, nullptr, go_on);
    style.faces = MeshStyle::Faces::VERTEX_COLORS;
  }

  /// Anew, with at most so many indices in a buffer where ranges allow it.
  void makeVisual(std::size_t indices_per_buffer)
  {
    visual.reset();
    visual = std::make_unique<rviz_mesh_plugin::MeshVisual>(parent, indices_per_buffer);
    visual->setStyle(style);
  }

  void show(const MeshLayoutConstPtr& shown)
  {
    visual->setLayout(shown);
    // Neighbors differ: a wrong face or vertex is seen.
    visual->setColors(
        [](const std::uint32_t* sources, std::size_t count, Rgba8* colors) {
          for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t mixed = sources[i] * 2654435761u;
            colors[i] = {static_cast<std::uint8_t>(mixed >> 24),
                         static_cast<std::uint8_t>(mixed >> 16),
                         static_cast<std::uint8_t>(mixed >> 8), 255};
          }
        },
        false);
    uploadAll();
  }

  std::vector<Image> pictures()
  {
    std::vector<Image> images;
    for (const View& view : VIEWS) {
      style.level_of_detail = view.level_of_detail;
      visual->setStyle(style);
      lookAt(view.eye, {0.0, 0.0, -0.2});
      images.push_back(grab());
    }
    return images;
  }

  void expectSame(const std::vector<Image>& images, const std::vector<Image>& expected)
  {
    for (std::size_t i = 0; i < images.size(); ++i) {
      EXPECT_TRUE(imagesMatch(std::string("buffers_") + VIEWS[i].name, images[i], expected[i]));
    }
  }

  std::size_t indexBuffers() { return counts().index_buffers - empty.index_buffers; }

  std::shared_ptr<rviz_mesh_plugin::MeshData> mesh;
  MeshLayoutConstPtr layout;
  MeshLayoutConstPtr by_face;
};

constexpr VisualBuffers::View VisualBuffers::VIEWS[];

TEST_F(VisualBuffers, several_look_as_one_in_all_levels_and_for_the_next_layout)
{
  makeVisual(layout->indices.size());
  show(layout);
  EXPECT_EQ(indexBuffers(), 1u);
  const auto expected = pictures();
  const std::size_t bytes = counts().index_buffer_bytes;
  show(by_face);
  const auto expected_by_face = pictures();
  ASSERT_GT(rangeCount(*layout), 20u);
  struct Limit
  {
    std::size_t indices;
    std::size_t least;
    std::size_t most;
  };
  const std::size_t all = layout->indices.size();
  for (const Limit& limit :
       {Limit{1, rangeCount(*layout), rangeCount(*layout)},
        Limit{40000, all / 40000 + 1, 2 * all / 40000 + 1}, Limit{all - 1, 2, 2}}) {
    SCOPED_TRACE(limit.indices);
    makeVisual(limit.indices);
    show(layout);
    EXPECT_GE(indexBuffers(), limit.least);
    EXPECT_LE(indexBuffers(), limit.most);
    EXPECT_EQ(counts().index_buffer_bytes, bytes) << "nothing lies in two buffers";
    expectSame(pictures(), expected);
    show(by_face);
    expectSame(pictures(), expected_by_face);
    show(layout);
    expectSame(pictures(), expected);
    EXPECT_EQ(counts().index_buffer_bytes, bytes);
  }
  visual.reset();
  EXPECT_EQ(counts().index_buffers, empty.index_buffers);
}

TEST_F(VisualBuffers, no_buffer_is_larger_than_the_limit_but_for_one_range)
{
  const std::uint32_t cells = 64;
  const auto tiles = test_layouts::tiled(grid(cells, flat), cells, 4, 3);
  // 16 parts with 1536, 384 and 96 indices.
  const std::vector<std::pair<std::size_t, std::size_t>> expected{
      {32256, 1}, {32255, 2}, {1536, 1 + 4 + 16}, {96, 48}, {95, 48}};
  for (const auto& [limit, buffers] : expected) {
    makeVisual(limit);
    visual->setLayout(tiles);
    uploadAll();
    EXPECT_EQ(indexBuffers(), buffers) << limit;
  }
}

TEST_F(VisualBuffers, a_mesh_without_coarser_levels_is_shown_when_all_of_it_is_there)
{
  style.faces = MeshStyle::Faces::FIXED_COLOR;
  for (const std::size_t limit : {std::size_t{1} << 20, std::size_t{1} << 30}) {
    makeVisual(limit);
    visual->setLayout(test_layouts::simple(grid(1, flat)));
    const auto before = visual->shownLayout();
    const auto layout = test_layouts::tiled(grid(700, flat), 700, 4, 1);
    visual->setLayout(layout);  // 12 MB of faces
    while (visual->shownLayout() == before) {
      ASSERT_LT(visual->progress(), 1.0f);
      visual->upload(std::chrono::microseconds(0));
    }
    EXPECT_EQ(visual->progress(), 1.0f);
    EXPECT_EQ(picture().count({0, 255, 0}), 40000u);
  }
}

TEST_F(VisualBuffers, while_they_are_uploaded_parts_are_drawn_coarser_but_all)
{
  const std::uint32_t cells = 512;
  const auto tiles = test_layouts::tiled(grid(cells, flat), cells, 8, 5);
  style.faces = MeshStyle::Faces::FIXED_COLOR;
  style.level_of_detail = false;
  makeVisual(100000);
  visual->setLayout(tiles);
  std::set<std::size_t> drawn;
  for (bool complete = false; !complete;) {
    complete = visual->upload(std::chrono::microseconds(0));
    if (visual->shownLayout() == visual->layout()) {
      ASSERT_EQ(picture().count({0, 255, 0}), 40000u);
      drawn.insert(visual->facesDrawn());
    }
  }
  ASSERT_GT(drawn.size(), 10u) << "ever finer";
  EXPECT_EQ(*drawn.rbegin(), 2u * cells * cells);
  EXPECT_EQ(visual->progress(), 1.0f);
}
