#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "visual_fixture.h"

using osmesa_harness::imagesMatch;
using osmesa_harness::isNear;
using rviz_mesh_plugin::FramePose;
using rviz_mesh_plugin::MeshStyle;
using rviz_mesh_plugin::Rgba8;
using test_layouts::flat;
using test_layouts::grid;

/// How faces look, from MeshVisual alone.
class VisualLooks : public VisualFixture
{
 protected:
  static constexpr Rgb GREEN{0, 255, 0};

  void apply() { visual->setStyle(style); }

  /// Colors that no two neighboring faces share.
  static std::vector<Rgba8> mixed(std::size_t count)
  {
    std::vector<Rgba8> colors;
    for (std::size_t i = 0; i < count; ++i) {
      colors.push_back({static_cast<std::uint8_t>(10 + 7 * i), static_cast<std::uint8_t>(11 * i),
                        static_cast<std::uint8_t>(255 - 9 * i), 255});
    }
    return colors;
  }
};

TEST_F(VisualLooks, one_color_vertex_colors_and_no_faces)
{
  draw(test_layouts::simple(grid(2, flat)));
  EXPECT_EQ(picture().count(GREEN), 200u * 200u);
  style.faces_color = Ogre::ColourValue(1.0f, 0.0f, 0.0f);
  apply();
  EXPECT_EQ(picture().count({255, 0, 0}), 200u * 200u);
  visual->setColors(colorsOf(std::vector<Rgba8>(9, Rgba8{1, 2, 3, 255})), false);
  EXPECT_EQ(picture().count({255, 0, 0}), 200u * 200u) << "the style asks for one color";
  style.faces = MeshStyle::Faces::VERTEX_COLORS;
  apply();
  EXPECT_EQ(picture().count({1, 2, 3}), 200u * 200u);
  visual->clearColors();
  EXPECT_EQ(picture().count({255, 0, 0}), 200u * 200u);
  style.faces = MeshStyle::Faces::HIDDEN;
  apply();
  EXPECT_EQ(picture().count(BACKGROUND), 640u * 480u);
  EXPECT_EQ(counts().vertex_buffers, empty.vertex_buffers + 2) << "the colors are freed";
}

TEST_F(VisualLooks, each_face_has_its_own_color)
{
  const auto mesh = grid(4, flat);
  draw(test_layouts::byFace(mesh));
  const auto colors = mixed(mesh->faceCount());
  visual->setColors(colorsOf(colors), false);
  style.faces = MeshStyle::Faces::VERTEX_COLORS;
  apply();
  const Image image = picture();
  for (int square = 0; square < 16; ++square) {
    const int left = 220 + square % 4 * 50;
    const int bottom = 339 - square / 4 * 50;
    for (const int upper : {0, 1}) {
      const Rgba8& color = colors[2 * square + upper];
      const Rgb expected{color.red, color.green, color.blue};
      // Far from the diagonal, and next to it.
      for (const int distance : {40, 3}) {
        const int x = left + (upper ? 5 : 5 + distance);
        const int y = bottom - (upper ? 5 + distance : 5);
        ASSERT_EQ(image.at(x, y), expected) << square << " " << upper << " " << distance;
      }
    }
  }
}

TEST_F(VisualLooks, colors_of_vertices_go_on_to_the_next_layout_of_the_mesh_those_of_faces_do_not)
{
  const auto mesh = grid(2, flat);
  style.faces = MeshStyle::Faces::VERTEX_COLORS;
  apply();
  draw(test_layouts::simple(mesh));
  visual->setColors(colorsOf(std::vector<Rgba8>(9, Rgba8{255, 0, 0, 255})), false);
  draw(test_layouts::tiled(mesh, 2, 2, 1));
  EXPECT_EQ(picture().count({255, 0, 0}), 200u * 200u) << "another layout of the same mesh";
  EXPECT_EQ(visual->colorUploads(), 2u);
  draw(test_layouts::byFace(mesh));
  EXPECT_EQ(picture().count(GREEN), 200u * 200u) << "colors of vertices are not those of faces";
  draw(test_layouts::simple(mesh));
  visual->setColors(colorsOf(std::vector<Rgba8>(9, Rgba8{255, 0, 0, 255})), false);
  draw(test_layouts::simple(grid(4, flat)));
  EXPECT_EQ(picture().count(GREEN), 200u * 200u) << "another mesh has other colors";
}

TEST_F(VisualLooks, culling_leaves_out_one_side)
{
  draw(test_layouts::simple(grid(2, flat)));
  using Culling = MeshStyle::Culling;
  for (const bool wireframe : {false, true}) {
    style.show_wireframe = wireframe;
    for (const bool above : {true, false}) {
      for (const auto culling : {Culling::NONE, Culling::BACK, Culling::FRONT}) {
        style.culling = culling;
        apply();
        lookAt({0.1, -0.1, above ? 3.0 : -3.0}, {0.0, 0.0, 0.0});
        const bool seen = culling == Culling::NONE || (culling == Culling::BACK) == above;
        const Image image = grab();
        EXPECT_EQ(image.count(BACKGROUND) < 640u * 480u, seen)
            << above << static_cast<int>(culling) << wireframe;
        EXPECT_EQ(image.count({0, 0, 0}) > 0, seen && wireframe);
      }
    }
  }
}

TEST_F(VisualLooks, flat_shading_lights_each_face_by_its_plane)
{
  const auto ridge = [](double x, double) { return -std::fabs(x); };
  draw(test_layouts::simple(grid(2, ridge)));
  const double from_above = 0.8 + 0.2 * std::sqrt(0.5);
  const auto shade = [=](double cosine) {
    return Rgb{0, static_cast<std::uint8_t>(std::lround(255.0 * (0.4 + 0.6 * cosine) * from_above)),
               0};
  };
  // On the ridge the normal points up, 45 degrees off the planes beside it.
  EXPECT_TRUE(isNear(picture().at(320, 230), GREEN, 3));
  style.flat_shading = true;
  apply();
  const Image image = picture();
  for (const int x : {250, 318, 322, 390}) {
    EXPECT_TRUE(isNear(image.at(x, 230), shade(std::sqrt(0.5)), 1)) << x << image.at(x, 230);
  }
}

TEST_F(VisualLooks, light_from_above_tells_floors_from_walls_and_ceilings)
{
  draw(test_layouts::simple(grid(2, flat)));
  style.flat_shading = true;
  apply();
  EXPECT_EQ(picture().count(GREEN), 200u * 200u) << "level ground has exactly its color";
  const auto shade = [](double share) {
    return Rgb{0, static_cast<std::uint8_t>(std::lround(255.0 * share)), 0};
  };
  lookAt({0.0, 0.001, -3.0}, {0.0, 0.0, 0.0});
  EXPECT_TRUE(isNear(grab().center(), shade(0.6), 2)) << "seen from below: a ceiling";
  visual->place(FramePose{{0.0f, 0.0f, 0.0f}, Ogre::Quaternion(Ogre::Degree(90), {0, 1, 0})});
  lookAt({3.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
  EXPECT_TRUE(isNear(grab().center(), shade(0.8), 2)) << "a wall";
}

TEST_F(VisualLooks, contour_lines_are_at_multiples_of_the_interval)
{
  draw(test_layouts::simple(grid(2, [](double x, double) { return 0.25 * x; })));
  const auto dark = [&] {
    const Image image = picture();
    std::vector<int> columns;
    for (int x = 222; x < 418; ++x) {
      if (image.at(x, 200).green < 120) {
        columns.push_back(x);
      }
    }
    return columns;
  };
  EXPECT_TRUE(dark().empty());
  style.contour_interval = 0.1f;  // heights from -0.25 to 0.25: every 40 pixels
  apply();
  std::vector<int> lines;
  for (const int x : dark()) {
    if (lines.empty() || x > lines.back() + 3) {
      lines.push_back(x);
    }
  }
  ASSERT_EQ(lines.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(lines[i], 240 + 40 * i, 2);
  }
}

TEST_F(VisualLooks, alpha_multiplies_that_of_the_colors)
{
  draw(test_layouts::simple(grid(2, flat)));
  style.faces = MeshStyle::Faces::VERTEX_COLORS;
  style.alpha = 0.5f;
  apply();
  EXPECT_EQ(picture().center(), GREEN) << "the one color has its own alpha";
  visual->setColors(colorsOf(std::vector<Rgba8>(9, Rgba8{255, 0, 0, 255})), false);
  EXPECT_TRUE(isNear(picture().center(), {152, 24, 24}, 1)) << picture().center();
  visual->setColors(colorsOf(std::vector<Rgba8>(9, Rgba8{255, 0, 0, 128})), true);
  EXPECT_TRUE(isNear(picture().center(), {100, 36, 36}, 1)) << picture().center();
  style.alpha = 1.0f;
  apply();
  EXPECT_TRUE(isNear(picture().center(), {152, 24, 24}, 1)) << picture().center();
}

TEST_F(VisualLooks, parts_of_a_translucent_mesh_are_drawn_from_far_to_near)
{
  // Two squares, one above the other, in the order of drawing from near to far.
  auto mesh = grid(1, flat);
  const auto upper = grid(1, [](double, double) { return 0.5; });
  mesh->vertices.insert(mesh->vertices.begin(), upper->vertices.begin(), upper->vertices.end());
  for (std::uint32_t i : std::vector<std::uint32_t>(mesh->indices)) {
    mesh->indices.push_back(i + 4);
  }
  mesh->upper[2] = 0.5f;
  auto layout = test_layouts::simple(mesh);
  layout->parts.push_back(layout->parts[0]);
  layout->parts[0].lower[2] = 0.5f;
  layout->parts[1].upper[2] = 0.0f;
  layout->parts[0].levels = {{0, 6}};
  layout->parts[1].levels = {{6, 6}};
  draw(layout);
  std::vector<Rgba8> colors(4, Rgba8{255, 0, 0, 128});
  colors.resize(8, Rgba8{0, 0, 255, 128});
  visual->setColors(colorsOf(colors), true);
  style.faces = MeshStyle::Faces::VERTEX_COLORS;
  apply();
  lookAt({0.1, 0.0, 4.0}, {0.0, 0.0, 0.0});
  EXPECT_GT(grab().center().red, grab().center().blue) << "red is nearer " << grab().center();
  lookAt({0.1, 0.0, -4.0}, {0.0, 0.0, 0.0});
  EXPECT_GT(grab().center().blue, grab().center().red) << "blue is nearer " << grab().center();
}

TEST_F(VisualLooks, normals_are_those_of_the_mesh_in_whichever_layout)
{
  const auto mesh = grid(2, flat);
  style.show_normals = true;
  style.normals_length = 0.5f;
  style.faces = MeshStyle::Faces::HIDDEN;
  apply();
  draw(test_layouts::simple(mesh));
  lookAt({0.0, -4.0, 0.5}, {0.0, 0.0, 0.5});
  const Image image = grab();
  EXPECT_GT(image.count({255, 0, 255}), 9u * 40u);
  const auto buffers = counts().vertex_buffers;
  draw(test_layouts::tiled(mesh, 2, 2, 2));
  EXPECT_TRUE(imagesMatch("normals", grab(), image));
  EXPECT_EQ(counts().vertex_buffers, buffers);
  style.show_normals = false;
  apply();
  EXPECT_EQ(grab().count(BACKGROUND), 640u * 480u);
}

TEST_F(VisualLooks, a_pose_that_is_not_finite_is_ignored)
{
  draw(test_layouts::simple(grid(2, flat)));
  visual->place(FramePose{{0.5f, 0.0f, 0.0f}, Ogre::Quaternion::IDENTITY});
  const Image image = picture();
  EXPECT_EQ(image.at(460, 240), GREEN);
  const float nan = std::nanf("");
  visual->place(FramePose{{nan, 0.0f, 0.0f}, Ogre::Quaternion::IDENTITY});
  visual->place(FramePose{{HUGE_VALF, 0.0f, 0.0f}, Ogre::Quaternion::IDENTITY});
  visual->place(FramePose{Ogre::Vector3::ZERO, {nan, 0.0f, 0.0f, 0.0f}});
  EXPECT_TRUE(imagesMatch("pose", picture(), image));
}

TEST_F(VisualLooks, huge_coordinates_do_not_disturb_the_scene)
{
  const auto mesh = grid(2, flat);
  mesh->vertices[0].position = {3e38f, -3e38f, 3e38f};
  mesh->lower = {-1, -3e38f, 0};
  mesh->upper = {3e38f, 1, 3e38f};
  style.show_normals = true;
  style.show_wireframe = true;
  apply();
  draw(test_layouts::simple(mesh));
  EXPECT_EQ(picture().at(350, 200), GREEN);
  lookAt({2.0, 2.0, 2.0}, {0.0, 0.0, 0.0});
  EXPECT_GT(grab().count(BACKGROUND), 0u);
}

TEST_F(VisualLooks, looks_the_same_on_all_back_ends)
{
  const auto mesh = grid(32, [](double x, double y) { return 0.3 * std::sin(4 * x + y * y); });
  draw(test_layouts::byFace(mesh));
  visual->setColors(colorsOf(mixed(mesh->faceCount())), false);
  style.faces = MeshStyle::Faces::VERTEX_COLORS;
  style.flat_shading = true;
  style.culling = MeshStyle::Culling::BACK;
  apply();
  lookAt({2.0, -2.0, 1.0}, {0.0, 0.0, 0.0});
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("face_colors", grab()));
}
