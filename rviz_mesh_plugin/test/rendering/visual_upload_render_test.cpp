#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <OgreRenderWindow.h>
#include <gtest/gtest.h>
#include <rviz/render_panel.h>
#include <rviz/selection/selection_manager.h>
#include <rviz/visualization_manager.h>

#include "support/layout_checks.h"
#include "visual_fixture.h"

using osmesa_harness::difference;
using osmesa_harness::imagesMatch;
using rviz_mesh_plugin::ColorSource;
using rviz_mesh_plugin::MeshStyle;
using rviz_mesh_plugin::Rgba8;
using rviz_mesh_plugin::SLICE_BYTES;
using test_layouts::flat;
using test_layouts::grid;

namespace {

double hills(double x, double y)
{
  return 0.15 * std::sin(5 * x) * std::cos(4 * y);
}

}  // namespace

/// Uploads in slices, levels of detail, and that nothing is left behind.
class VisualUpload : public VisualFixture
{
 protected:
  static constexpr Rgb GREEN{0, 255, 0};

  void showColors()
  {
    style.faces = MeshStyle::Faces::VERTEX_COLORS;
    visual->setStyle(style);
  }

  /// Expects the same picture with levels of detail as without; returns how many faces they have.
  std::size_t drawnAlike(const char* name, double limit)
  {
    style.level_of_detail = true;
    visual->setStyle(style);
    const Image simplified = grab();
    const std::size_t faces = visual->facesDrawn();
    style.level_of_detail = false;
    visual->setStyle(style);
    EXPECT_TRUE(imagesMatch(name, simplified, grab(), limit)) << faces;
    EXPECT_EQ(visual->facesDrawn(), visual->layout()->mesh->faceCount());
    return faces;
  }

  static ColorSource oneColor(const Rgba8& color, std::size_t* asked = nullptr)
  {
    return [color, asked](const std::uint32_t*, std::size_t count, Rgba8* colors) {
      std::fill(colors, colors + count, color);
      if (asked) {
        *asked += count;
      }
    };
  }
};

TEST_F(VisualUpload, a_small_mesh_is_there_at_once)
{
  visual->setLayout(test_layouts::simple(grid(10, flat)));
  EXPECT_TRUE(visual->upload(std::chrono::microseconds(0)));
  EXPECT_EQ(visual->progress(), 1.0f);
  EXPECT_EQ(visual->geometryUploads(), 1u);
  EXPECT_EQ(visual->layout(), visual->shownLayout());
}

TEST_F(VisualUpload, the_old_picture_stays_until_the_new_one_has_its_coarsest_level_and_colors)
{
  visual->setLayout(test_layouts::simple(grid(1, flat)));
  const auto old_layout = visual->layout();
  showColors();
  visual->setColors(oneColor({255, 0, 0, 255}), false);
  const auto mesh = grid(512, flat);
  const auto layout = test_layouts::tiled(mesh, 512, 8, 5);
  visual->setLayout(layout);
  visual->setColors(oneColor({0, 0, 255, 255}), false);
  EXPECT_EQ(visual->layout()->mesh, mesh);
  float progress = -1.0f;
  std::size_t slices = 0;
  while (visual->shownLayout() == old_layout) {
    ASSERT_EQ(picture().count({255, 0, 0}), 40000u) << slices;
    ASSERT_GE(visual->progress(), progress);
    progress = visual->progress();
    ASSERT_FALSE(visual->upload(std::chrono::microseconds(0)));
    ASSERT_LT(++slices, 100u);
  }
  // 263,169 positions, as many normals, colors in two slices, then the first of the faces; three
  // more to allocate.
  EXPECT_EQ(slices, 8u);
  EXPECT_EQ(picture().count({0, 0, 255}), 40000u);
  EXPECT_LT(visual->progress(), 1.0f);
  EXPECT_EQ(visual->geometryUploads(), 1u);
  style.level_of_detail = false;
  visual->setStyle(style);
  EXPECT_EQ(picture().count({0, 0, 255}), 40000u) << "coarser where the finest is not there yet";
  EXPECT_LT(visual->facesDrawn(), mesh->faceCount());
  uploadAll();
  picture();
  EXPECT_EQ(visual->facesDrawn(), mesh->faceCount());
  EXPECT_EQ(visual->progress(), 1.0f);
  EXPECT_EQ(visual->geometryUploads(), 2u);
  EXPECT_EQ(visual->colorUploads(), 2u);
}

TEST_F(VisualUpload, new_colors_replace_the_old_ones_all_together)
{
  draw(test_layouts::simple(grid(700, flat)));
  showColors();
  visual->setColors(oneColor({255, 0, 0, 255}), false);
  uploadAll();
  const auto buffers = counts().vertex_buffers;
  std::size_t asked = 0;
  visual->setColors(oneColor({0, 0, 255, 255}, &asked), false);
  for (std::size_t before = asked; !visual->upload(std::chrono::microseconds(0)); before = asked) {
    EXPECT_LE(asked - before, 1u << 18);
    if (asked < 701u * 701u) {
      ASSERT_EQ(picture().count({255, 0, 0}), 40000u) << asked;
    }
  }
  EXPECT_EQ(asked, 701u * 701u);
  EXPECT_EQ(picture().count({0, 0, 255}), 40000u);
  EXPECT_EQ(visual->colorUploads(), 2u);
  EXPECT_EQ(visual->geometryUploads(), 1u);
  EXPECT_EQ(counts().vertex_buffers, buffers) << "the old colors are freed";
}

TEST_F(VisualUpload, colors_that_come_faster_than_they_upload_are_shown_in_turns)
{
  draw(test_layouts::simple(grid(700, flat)));  // two slices
  showColors();
  visual->setColors(oneColor({255, 0, 0, 255}), false);
  uploadAll();
  const auto shade = [](int i) { return static_cast<std::uint8_t>(10 * i); };
  for (int i = 1; i <= 20; ++i) {
    visual->setColors(oneColor({0, shade(i), 255, 255}), i % 3 == 0);
    visual->upload(std::chrono::microseconds(0));
    ASSERT_EQ(visual->colorUploads(), 1u + i / 2) << i;
    if (i % 2 == 0) {
      ASSERT_EQ(picture().count({0, shade(i - 1), 255}), 40000u) << i;
    }
  }
  visual->setColors(oneColor({0, 255, 0, 255}), false);
  uploadAll();
  EXPECT_EQ(picture().count({0, 255, 0}), 40000u) << "the last one, and none of before";
  EXPECT_EQ(visual->colorUploads(), 12u);
}

TEST_F(VisualUpload, colors_that_come_without_an_end_let_the_faces_come)
{
  visual->setLayout(test_layouts::simple(grid(1, flat)));
  showColors();
  const auto mesh = grid(512, flat);
  visual->setLayout(test_layouts::tiled(mesh, 512, 8, 5));
  for (int i = 0; visual->progress() < 1.0f; ++i) {
    ASSERT_LT(i, 200);
    visual->setColors(oneColor({255, 0, 0, 255}), false);
    visual->upload(std::chrono::microseconds(0));
  }
  EXPECT_EQ(visual->shownLayout()->mesh, mesh);
  EXPECT_EQ(picture().count({255, 0, 0}), 40000u);
}

TEST_F(VisualUpload, colors_that_fail_are_followed_by_the_next)
{
  draw(test_layouts::simple(grid(700, flat)));
  showColors();
  int asked = 0;
  visual->setColors(
      [&asked](const std::uint32_t*, std::size_t count, Rgba8* colors) {
        std::fill(colors, colors + count, Rgba8{255, 0, 0, 255});
        if (++asked > 1) {
          throw std::runtime_error("no colors");
        }
      },
      false);
  visual->upload(std::chrono::microseconds(0));
  visual->setColors(oneColor({0, 0, 255, 255}), false);
  EXPECT_THROW(uploadAll(), std::runtime_error);
  uploadAll();
  EXPECT_EQ(picture().count({0, 0, 255}), 40000u);
}

TEST_F(VisualUpload, an_update_asks_for_and_changes_what_it_names_only)
{
  const auto mesh = grid(400, flat);
  auto layout = test_layouts::simple(mesh);
  // As after sorting: vertices in another order, some of them twice.
  const auto count = static_cast<std::uint32_t>(mesh->vertexCount());
  layout->vertices.clear();
  layout->sources.clear();
  for (std::uint32_t i = 0; i < count + 1000; ++i) {
    layout->sources.push_back((2 * count - 1 - i) % count);
    layout->vertices.push_back(mesh->vertices[layout->sources.back()]);
  }
  std::vector<std::uint32_t> places(count);
  for (std::uint32_t i = 0; i < count + 1000; ++i) {
    places[layout->sources[i]] = i;
  }
  for (auto& index : layout->indices) {
    index = places[index];
  }
  draw(layout);
  showColors();
  const auto values = std::make_shared<std::vector<Rgba8>>(count, Rgba8{255, 0, 0, 255});
  std::size_t asked = 0;
  const rviz_mesh_plugin::ColorSource source = [values, &asked](const std::uint32_t* sources,
                                                                std::size_t number, Rgba8* colors) {
    asked += number;
    for (std::size_t i = 0; i < number; ++i) {
      colors[i] = (*values)[sources[i]];
    }
  };
  visual->setColors(source, false);
  uploadAll();
  EXPECT_EQ(picture().count({255, 0, 0}), 40000u);
  asked = 0;
  std::vector<std::uint32_t> changed;
  for (std::uint32_t row = 100; row < 200; ++row) {
    for (std::uint32_t column = 50; column < 150; ++column) {
      changed.push_back(401 * row + column);
      (*values)[changed.back()] = {0, 0, 255, 255};
    }
  }
  changed.push_back(count);  // beyond the mesh: ignored
  changed.push_back(0xFFFFFFFFu);
  visual->updateColors(source, changed);
  uploadAll();
  EXPECT_LE(asked, 100u * 100u + 1000u) << "1000 vertices are there twice";
  EXPECT_GE(asked, 100u * 100u);
  EXPECT_EQ(visual->colorUploads(), 1u) << "not all";
  // The half of the pixels beside the changed vertices is a mixture.
  EXPECT_NEAR(picture().count({0, 0, 255}), 49.5 * 49.5, 100.0);
  EXPECT_NEAR(picture().count({255, 0, 0}), 40000 - 50.5 * 50.5, 200.0);
  const Image updated = picture();
  visual->updateColors(source, test_layouts::iota(count));
  uploadAll();
  EXPECT_EQ(visual->colorUploads(), 2u) << "where most change, all are uploaded";
  EXPECT_TRUE(imagesMatch("updated", picture(), updated));
}

TEST_F(VisualUpload, updates_while_colors_are_uploaded_are_not_lost)
{
  const auto mesh = grid(700, flat);
  draw(test_layouts::simple(mesh));
  showColors();
  visual->setColors(oneColor({255, 0, 0, 255}), false);
  visual->upload(std::chrono::microseconds(0));  // the first 262,144
  // Of two of them each is few enough not to have all colored anew.
  for (const std::uint32_t begin : {0u, 20000u}) {
    std::vector<std::uint32_t> changed = test_layouts::iota(20000);
    for (std::uint32_t& vertex : changed) {
      vertex += begin;
    }
    visual->updateColors(oneColor({0, 0, 255, 255}), changed);
  }
  visual->updateColors(oneColor({0, 0, 255, 255}), test_layouts::iota(1 << 18));
  uploadAll();
  EXPECT_EQ(picture().count({0, 0, 255}), 40000u);
}

TEST_F(VisualUpload, no_slice_is_larger_than_the_limit)
{
  // 13.8 MB of vertices and 14.9 MB of faces.
  const auto layout = test_layouts::tiled(grid(758, flat), 758, 2, 1);
  const std::size_t bytes = 24 * layout->vertices.size() + 4 * layout->indices.size();
  visual->setLayout(layout);
  float before = visual->progress();
  std::size_t slices = 0;
  for (; !visual->upload(std::chrono::microseconds(0)); ++slices) {
    EXPECT_LE((visual->progress() - before) * bytes, 1.001 * SLICE_BYTES);
    before = visual->progress();
  }
  EXPECT_EQ(slices, 3 + 2 * ((12 * layout->vertices.size() + SLICE_BYTES - 1) / SLICE_BYTES) +
                        (4 * layout->indices.size() + SLICE_BYTES - 1) / SLICE_BYTES);
}

TEST_F(VisualUpload, keeps_only_the_outline_of_what_is_uploaded)
{
  auto layout = test_layouts::tiled(grid(512, flat), 512, 8, 5);
  const std::weak_ptr<const rviz_mesh_plugin::MeshLayout> held = layout;
  visual->setLayout(layout);
  layout = nullptr;
  EXPECT_FALSE(held.expired());
  uploadAll();
  EXPECT_TRUE(held.expired());
  EXPECT_EQ(visual->layout()->parts.size(), 64u);
  showColors();
  visual->setColors(oneColor({0, 0, 255, 255}), false);
  uploadAll();
  visual->updateColors(oneColor({0, 0, 255, 255}), {0, 1, 2});
  uploadAll();
  EXPECT_EQ(picture().count({0, 0, 255}), 40000u);
}

TEST_F(VisualUpload, memory_is_28_bytes_per_vertex_and_12_per_face)
{
  const auto mesh = grid(100, flat);
  draw(test_layouts::simple(mesh));
  showColors();
  visual->setColors(oneColor({255, 0, 0, 255}), false);
  uploadAll();
  EXPECT_EQ(visual->gpuBytes(), 28 * mesh->vertexCount() + 12 * mesh->faceCount());
  const auto now = counts();
  EXPECT_EQ(now.vertex_buffer_bytes - empty.vertex_buffer_bytes, 28 * mesh->vertexCount());
  EXPECT_EQ(now.index_buffer_bytes - empty.index_buffer_bytes, 12 * mesh->faceCount());
}

TEST_F(VisualUpload, far_away_fewer_faces_look_the_same)
{
  const auto mesh = grid(512, hills);
  draw(test_layouts::tiled(mesh, 512, 16, 7));
  lookAt({20.0, 20.0, 15.0}, {0.0, 0.0, 0.0});
  const std::size_t far = drawnAlike("far", 1e-4);
  EXPECT_LT(far, mesh->faceCount() / 500);
  lookAt({2.5, 2.5, 2.0}, {0.0, 0.0, 0.0});
  const std::size_t middle = drawnAlike("middle", 2e-4);
  EXPECT_LT(middle, mesh->faceCount() / 3);
  EXPECT_GT(middle, 4 * far);
  viewFromAbove(0.0, 0.0, 10.0);
  const std::size_t small = drawnAlike("orthographic_small", 1e-4);
  EXPECT_LT(small, mesh->faceCount() / 500);
  viewFromAbove(0.0, 0.0, 1000.0);
  EXPECT_GT(drawnAlike("orthographic_large", 1e-4), mesh->faceCount() / 5);
}

TEST_F(VisualUpload, levels_of_detail_look_like_the_whole_mesh)
{
  if (!layout_checks::canSimplify()) {
    return;
  }
  const auto mesh = grid(700, hills);
  const std::atomic<bool> go_on{false};
  visual->setLayout(rviz_mesh_plugin::layOut(mesh, rviz_mesh_plugin::Split::NONE, nullptr, go_on));
  uploadAll();
  lookAt({20.0, 20.0, 15.0}, {0.0, 0.0, 0.0});
  EXPECT_LT(drawnAlike("real_far", 3e-6), mesh->faceCount() / 30);
  lookAt({3.0, 3.0, 2.5}, {0.0, 0.0, 0.0});
  EXPECT_LT(drawnAlike("real_middle", 1e-5), mesh->faceCount() / 3);
  lookAt({0.5, 0.5, 0.4}, {0.0, 0.0, 0.0});
  EXPECT_GT(drawnAlike("real_near", 3e-6), mesh->faceCount() / 30);
}

TEST_F(VisualUpload, neighbors_in_different_detail_leave_no_gaps)
{
  const auto mesh = grid(700, hills);
  const std::atomic<bool> go_on{false};
  const auto layout = rviz_mesh_plugin::layOut(mesh, rviz_mesh_plugin::Split::NONE, nullptr, go_on);
  draw(std::make_shared<rviz_mesh_plugin::MeshLayout>(*layout));
  const Rgb background = [&] {
    visual->setVisible(false);
    const Rgb color = grab().center();
    visual->setVisible(true);
    return color;
  }();
  for (const float pixels : {2.0f, 4.0f}) {
    style.detail_pixels = pixels;
    visual->setStyle(style);
    for (const double distance : {0.1, 0.2, 0.35}) {
      // Along the surface: near and far parts, and nothing but mesh below.
      lookAt({-0.6, -0.6, 0.15 + distance}, {0.3, 0.3, -0.6});
      const Image image = grab();
      std::size_t holes = 0;
      for (int x = 0; x < image.width(); ++x) {
        int y = 0;
        while (y < image.height() && image.at(x, y) == background) {
          ++y;
        }
        for (; y < image.height(); ++y) {
          holes += image.at(x, y) == background ? 1 : 0;
        }
      }
      EXPECT_EQ(holes, 0u) << pixels << " pixels, from " << distance << " m above";
      image.save(osmesa_harness::resultsFolder() + "/gaps_" + std::to_string(pixels) + "_" +
                 std::to_string(distance) + ".png");
    }
  }
}

TEST_F(VisualUpload, more_pixels_of_detail_draw_fewer_faces)
{
  const auto mesh = grid(512, hills);
  draw(test_layouts::tiled(mesh, 512, 16, 7));
  lookAt({2.5, 2.5, 2.0}, {0.0, 0.0, 0.0});
  std::size_t before = mesh->faceCount() + 1;
  for (const float pixels : {0.0f, 1.0f, 3.0f, 10.0f, 50.0f}) {
    style.detail_pixels = pixels;
    visual->setStyle(style);
    grab();
    EXPECT_LT(visual->facesDrawn(), before) << pixels;
    before = visual->facesDrawn();
  }
}

TEST_F(VisualUpload, what_is_out_of_view_is_culled)
{
  draw(test_layouts::tiled(grid(64, flat), 64, 8, 1));
  picture();
  const auto drawn = [&] {
    grab();
    return panel()->getRenderWindow()->getStatistics().triangleCount;
  };
  const std::size_t all = drawn();
  viewFromAbove(-0.9, -0.9, 3000.0);
  EXPECT_LT(drawn() + 50 * 128u, all) << "no more than the parts around the corner";
}

TEST_F(VisualUpload, counts_are_those_of_the_start_after_1000_layouts)
{
  showColors();
  style.show_normals = true;
  style.show_wireframe = true;
  visual->setStyle(style);
  for (int i = 0; i < 1000; ++i) {
    const std::uint32_t cells = 4u << i % 3;
    const auto mesh = grid(cells, flat);
    visual->setLayout(i % 2 == 0 ? test_layouts::tiled(mesh, cells, 2, 2)
                                 : test_layouts::byFace(mesh));
    if (i % 5 != 0) {
      visual->setColors(oneColor({255, 0, 0, 255}), i % 7 == 0);
    }
    if (i % 100 == 0) {
      grab();
    }
  }
  const auto last = counts();
  EXPECT_EQ(last.materials, empty.materials + 2) << "faces and normals";
  EXPECT_LT(last.nodes, empty.nodes + 20) << "of the parts of the last layout alone";
  visual.reset();
  EXPECT_EQ(counts(), empty);
}

TEST_F(VisualUpload, a_visual_may_go_in_the_middle_of_an_upload)
{
  for (std::size_t slices = 0; slices < 12; ++slices) {
    visual->setLayout(test_layouts::simple(grid(1, flat)));
    visual->setLayout(test_layouts::tiled(grid(512, flat), 512, 8, 3));
    visual->setColors(oneColor({255, 0, 0, 255}), false);
    for (std::size_t i = 0; i < slices; ++i) {
      visual->upload(std::chrono::microseconds(0));
    }
    if (slices % 2 == 0) {
      visual->setLayout(test_layouts::simple(grid(2, flat)));  // overtaken
      EXPECT_EQ(picture().count(GREEN), 40000u);
    }
    visual.reset();
    EXPECT_EQ(counts(), empty) << slices;
    makeVisual();
  }
}

TEST_F(VisualUpload, colors_that_fail_leave_the_old_picture)
{
  draw(test_layouts::simple(grid(1, flat)));
  const auto old_layout = visual->layout();
  visual->setLayout(test_layouts::simple(grid(512, flat)));
  visual->setColors(
      [](const std::uint32_t*, std::size_t, Rgba8*) { throw std::runtime_error("no colors"); },
      false);
  EXPECT_THROW(uploadAll(), std::runtime_error);
  EXPECT_EQ(visual->layout(), old_layout);
  EXPECT_TRUE(visual->upload());
  EXPECT_EQ(picture().count(GREEN), 40000u);
  draw(test_layouts::simple(grid(512, flat)));
  EXPECT_EQ(picture().count(GREEN), 40000u);
}

TEST_F(VisualUpload, an_empty_layout_draws_nothing)
{
  draw(test_layouts::simple(grid(1, flat)));
  auto layout = std::make_shared<rviz_mesh_plugin::MeshLayout>();
  layout->mesh = std::make_shared<rviz_mesh_plugin::MeshData>();
  style.show_normals = true;
  visual->setStyle(style);
  draw(layout);
  visual->setColors(oneColor({255, 0, 0, 255}), false);
  visual->updateColors(oneColor({0, 0, 255, 255}), {0});
  uploadAll();
  EXPECT_EQ(picture().count(BACKGROUND), 640u * 480u);
}

TEST_F(VisualUpload, calls_before_the_first_layout_do_nothing)
{
  visual->setColors(oneColor({255, 0, 0, 255}), false);
  visual->updateColors(oneColor({0, 0, 255, 255}), {0});
  visual->clearColors();
  visual->clearTextures();
  visual->setTexture(std::make_shared<rviz_mesh_plugin::TextureImage>());
  visual->setStyle(style);
  EXPECT_TRUE(visual->upload());
  EXPECT_EQ(visual->gpuBytes(), 0u);
  EXPECT_EQ(visual->facesDrawn(), 0u);
}

TEST_F(VisualUpload, a_hidden_visual_is_uploaded_and_shown_later)
{
  visual->setVisible(false);
  draw(test_layouts::simple(grid(2, flat)));
  EXPECT_EQ(picture().count(BACKGROUND), 640u * 480u);
  visual->setVisible(true);
  EXPECT_EQ(picture().count(GREEN), 40000u);
}

TEST_F(VisualUpload, rviz_selects_and_focuses_through_all_parts)
{
  draw(test_layouts::tiled(grid(64, [](double, double) { return 0.25; }), 64, 8, 3));
  for (const auto culling : {MeshStyle::Culling::NONE, MeshStyle::Culling::BACK}) {
    style.culling = culling;
    visual->setStyle(style);
    picture();
    auto* selection = manager()->getSelectionManager();
    Ogre::Vector3 hit;
    ASSERT_TRUE(selection->get3DPoint(panel()->getViewport(), 370, 190, hit));
    EXPECT_NEAR(hit.x, 0.5, 0.02);
    EXPECT_NEAR(hit.y, 0.5, 0.02);
    EXPECT_NEAR(hit.z, 0.25, 0.02);
    selection->select(panel()->getViewport(), 200, 100, 440, 360, rviz::SelectionManager::Replace);
    EXPECT_TRUE(selection->getSelection().empty());
    EXPECT_EQ(picture().count(GREEN), 40000u);
  }
}
