#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <OgreRenderWindow.h>
#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <gtest/gtest.h>
#include <rviz/render_panel.h>

#include "rendering/labels/label_overlay.h"
#include "support/label_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;
using rviz_mesh_plugin::LabelOverlay;
using rviz_mesh_plugin::MeshDataConstPtr;
using rviz_mesh_plugin::MeshVisual;
using rviz_mesh_plugin::Rgba8;
using test_labels::flatGrid;
using test_labels::put;
using test_labels::ROW;
using test_labels::rows;

namespace {

const Rgb BACKGROUND{48, 48, 48};
const Rgb GREEN{0, 255, 0};
const Rgb RED{255, 0, 0};
const Rgb BLUE{0, 0, 255};
const Rgba8 RED_COLOR{255, 0, 0, 255};
const Rgba8 BLUE_COLOR{0, 0, 255, 255};
constexpr std::uint32_t CELLS = 10;  // of 20 pixels each

void uploadAll(LabelOverlay& overlay)
{
  for (int i = 0; i < 20000 && !overlay.upload(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // for its thread
  }
  ASSERT_TRUE(overlay.upload());
}

}  // namespace

/// Overlays on the root of the scene; from above at 100 pixels per meter, the square [-1, 1]²
/// covers columns 220..419 and rows 140..339.
class LabelOverlayTest : public osmesa_harness::RenderFixture
{
 protected:
  void SetUp() override
  {
    osmesa_harness::RenderFixture::SetUp();
    root = sceneManager()->getRootSceneNode();
    overlay = std::make_unique<LabelOverlay>(root);
  }

  void TearDown() override
  {
    overlay.reset();
    visual.reset();
    osmesa_harness::RenderFixture::TearDown();
  }

  /// Draws the mesh itself in green.
  void drawMesh(const MeshDataConstPtr& mesh, bool wireframe = false)
  {
    visual = std::make_unique<MeshVisual>(root);
    const std::atomic<bool> canceled{false};
    visual->setLayout(
        rviz_mesh_plugin::layOut(mesh, rviz_mesh_plugin::Split::NONE, nullptr, canceled));
    style.show_wireframe = wireframe;
    visual->setStyle(style);
    while (!visual->upload()) {
    }
  }

  void label(const std::string& name, const std::vector<std::uint32_t>& faces, const Rgba8& color)
  {
    overlay->setColor(name, color);
    EXPECT_EQ(put(*overlay, {name, faces}), 0u);
  }

  Image picture()
  {
    uploadAll(*overlay);
    viewFromAbove();
    return grab();
  }

  Ogre::SceneNode* root = nullptr;
  rviz_mesh_plugin::MeshStyle style;
  std::unique_ptr<MeshVisual> visual;
  std::unique_ptr<LabelOverlay> overlay;
};

TEST_F(LabelOverlayTest, labelled_faces_have_their_color_and_the_others_that_of_the_mesh)
{
  const auto mesh = flatGrid(CELLS);
  drawMesh(mesh);
  overlay->setMesh(mesh);
  label("tree_1", rows(CELLS, 0, 3), RED_COLOR);
  label("tree_2", rows(CELLS, 9, 10), BLUE_COLOR);
  Image image = picture();
  EXPECT_EQ(image.count(RED), 3 * ROW);
  EXPECT_EQ(image.count(BLUE), ROW);
  EXPECT_EQ(image.count(GREEN), 6 * ROW);
  EXPECT_EQ(image.at(320, 141), BLUE) << "the last row is above";
  visual->setVisible(false);
  image = picture();
  EXPECT_EQ(image.count(RED), 3 * ROW) << "without the mesh";
  EXPECT_EQ(image.count(BACKGROUND), 640u * 480u - 4 * ROW);
  overlay->removeLabel("tree_1");
  overlay->setColor("tree_2", RED_COLOR);
  EXPECT_EQ(picture().count(RED), ROW);
  overlay->setVisible(false);
  EXPECT_EQ(picture().count(BACKGROUND), 640u * 480u);
  overlay->setVisible(true);
  put(*overlay, {"tree_2", {}});
  EXPECT_EQ(picture().count(BACKGROUND), 640u * 480u);
}

TEST_F(LabelOverlayTest, the_wireframe_of_the_mesh_is_drawn_over_labels)
{
  const auto mesh = flatGrid(CELLS);
  drawMesh(mesh, true);
  overlay->setMesh(mesh);
  label("tree_1", rows(CELLS, 0, CELLS), RED_COLOR);
  const Image image = picture();
  EXPECT_EQ(image.count(GREEN), 0u);
  EXPECT_GT(image.count({0, 0, 0}), 2000u);
  EXPECT_GT(image.count(RED), 30000u);
}

TEST_F(LabelOverlayTest, of_labels_on_the_same_faces_the_last_in_natural_order_is_seen)
{
  const auto mesh = flatGrid(CELLS);
  drawMesh(mesh);
  overlay->setMesh(mesh);
  label("tree_10", rows(CELLS, 0, 4), BLUE_COLOR);
  label("tree_9", rows(CELLS, 2, 6), RED_COLOR);
  Image image = picture();
  EXPECT_EQ(image.count(BLUE), 4 * ROW);
  EXPECT_EQ(image.count(RED), 2 * ROW);
  label("tree_11", rows(CELLS, 3, 5), {9, 9, 9, 255});
  image = picture();
  EXPECT_EQ(image.count(BLUE), 3 * ROW);
  EXPECT_EQ(image.count(RED), ROW);
  EXPECT_EQ(image.count({9, 9, 9}), 2 * ROW);
  overlay->setVisible("tree_10", false);
  image = picture();
  EXPECT_EQ(image.count(BLUE), 0u);
  EXPECT_EQ(image.count(RED), 2 * ROW);
}

TEST_F(LabelOverlayTest, visibility_and_color_may_be_set_before_the_label_and_survive_a_new_mesh)
{
  overlay->setVisible("a_1", false);
  overlay->setColor("a_2", BLUE_COLOR);
  for (int i = 0; i < 2; ++i) {
    overlay->setMesh(flatGrid(CELLS));
    EXPECT_EQ(picture().count(BACKGROUND), 640u * 480u) << "labels are gone";
    put(*overlay, {"a_1", rows(CELLS, 0, 1)});
    put(*overlay, {"a_2", rows(CELLS, 1, 2)});
    const Image image = picture();
    EXPECT_EQ(image.count(BLUE), ROW);
    EXPECT_EQ(image.count(BACKGROUND), 640u * 480u - ROW);
  }
}

TEST_F(LabelOverlayTest, translucent_labels_blend_with_the_mesh_behind_them)
{
  const auto mesh = flatGrid(CELLS);
  drawMesh(mesh);
  overlay->setMesh(mesh);
  label("tree_1", rows(CELLS, 0, 2), RED_COLOR);
  overlay->setAlpha(0.5f);
  Image image = picture();
  EXPECT_TRUE(isNear(image.at(320, 330), {128, 127, 0}, 1)) << image.at(320, 330);
  EXPECT_EQ(image.at(320, 200), GREEN);
  label("tree_2", rows(CELLS, 2, 3), BLUE_COLOR);
  image = picture();
  EXPECT_TRUE(isNear(image.at(320, 290), {0, 127, 128}, 1)) << "one that came later";
  overlay->setAlpha(1.0f);
  EXPECT_EQ(picture().at(320, 330), RED);
  overlay->setAlpha(0.0f);
  EXPECT_EQ(picture().count(GREEN), 10 * ROW);
}

TEST_F(LabelOverlayTest, the_phantom_is_the_whole_mesh)
{
  const auto before = counts();
  overlay->setMesh(flatGrid(CELLS));
  overlay->setPhantom(true);
  const Image image = picture();
  EXPECT_EQ(image.count(BACKGROUND), 640u * 480u - 10 * ROW);
  const double alpha = 26.0 / 255.0;
  const auto blend = [&](int color) {
    return static_cast<std::uint8_t>(std::lround(48 * (1.0 - alpha) + color * alpha));
  };
  EXPECT_TRUE(isNear(image.center(), {blend(51), blend(76), blend(51)}, 1)) << image.center();
  overlay->setMesh(flatGrid(2));
  EXPECT_EQ(picture().count(BACKGROUND), 640u * 480u - 10 * ROW) << "of another mesh, too";
  overlay->setPhantom(false);
  EXPECT_EQ(picture().count(BACKGROUND), 640u * 480u);
  EXPECT_EQ(counts().index_buffers, before.index_buffers);
}

TEST_F(LabelOverlayTest, only_what_has_changed_is_uploaded)
{
  constexpr std::uint32_t FINE = 100;
  const auto mesh = flatGrid(FINE);
  overlay->setMesh(mesh);
  uploadAll(*overlay);
  EXPECT_EQ(overlay->uploadedBytes(), 0u) << "nothing without a label";
  std::vector<std::uint32_t> faces = rows(FINE, 0, 50);
  label("tree_1", faces, RED_COLOR);
  uploadAll(*overlay);
  std::size_t uploaded = overlay->uploadedBytes();
  EXPECT_EQ(uploaded, 24 * mesh->vertexCount() + 12 * faces.size());
  for (std::uint32_t i = 0; i < 10; ++i) {
    faces.push_back(15000 + i);
  }
  label("tree_1", faces, RED_COLOR);
  uploadAll(*overlay);
  EXPECT_EQ(overlay->uploadedBytes() - uploaded, 120u) << "10 faces more";
  uploaded = overlay->uploadedBytes();
  faces.erase(faces.begin(), faces.begin() + 5);
  label("tree_1", faces, RED_COLOR);
  uploadAll(*overlay);
  EXPECT_EQ(overlay->uploadedBytes() - uploaded, 60u) << "5 faces less";
  uploaded = overlay->uploadedBytes();
  label("tree_1", faces, BLUE_COLOR);
  overlay->setVisible("tree_1", false);
  overlay->setVisible("tree_1", true);
  overlay->setAlpha(0.3f);
  uploadAll(*overlay);
  EXPECT_EQ(overlay->uploadedBytes(), uploaded) << "a change of look";
}

TEST_F(LabelOverlayTest, uploads_go_in_slices_and_a_label_shows_once_it_is_complete)
{
  constexpr std::uint32_t FINE = 500;
  const auto mesh = flatGrid(FINE);
  const std::size_t total = 24 * mesh->vertexCount() + 12 * mesh->faceCount();
  overlay->setMesh(mesh);
  label("all", rows(FINE, 0, FINE), RED_COLOR);
  std::size_t before = 0;
  int slices = 0;
  bool done = false;
  while (!done) {
    viewFromAbove();
    if (overlay->uploadedBytes() < total) {
      EXPECT_EQ(grab().count(RED), 0u) << slices;
    }
    for (int i = 0; i < 4 && !done; ++i) {
      done = overlay->upload(std::chrono::microseconds(0));
      EXPECT_LE(overlay->uploadedBytes() - before, (std::size_t(1) << 20) + 24 * 8192)
          << "a part may be left of it";
      before = overlay->uploadedBytes();
      ++slices;
    }
  }
  EXPECT_GE(slices, 11);
  EXPECT_NEAR(static_cast<double>(picture().count(RED)), 10.0 * ROW, 0.001 * 10 * ROW);
}

TEST_F(LabelOverlayTest, labels_of_many_faces_together_take_part_in_levels_of_detail)
{
  constexpr std::uint32_t FINE = 400;
  const auto mesh = rviz_mesh_plugin::convert(test_meshes::terrain(
      FINE, [](double x, double y) { return 0.05 * std::sin(9 * x) * std::cos(7 * y); }));
  drawMesh(mesh);
  overlay->setMesh(mesh);
  label("wall_1", rows(FINE, 0, 100), RED_COLOR);
  label("wall_2", rows(FINE, 100, 200), BLUE_COLOR);
  label("wall_3", rows(FINE, 200, 300), RED_COLOR);
  label("wall_4", rows(FINE, 300, 400), BLUE_COLOR);
  uploadAll(*overlay);
  lookAt({0, 0, 12}, {0, 0.001, 0});
  const Image far = grab();
  far.save(osmesa_harness::resultsFolder() + "/labels_levels_far.png");
  EXPECT_LT(overlay->facesDrawn(), mesh->faceCount() / 2) << "the first was alone, and stays";
  std::size_t red = 0, blue = 0, green = 0;
  for (int y = 0; y < far.height(); ++y) {
    for (int x = 0; x < far.width(); ++x) {
      const Rgb color = far.at(x, y);
      red += color.red > color.green + 100;
      blue += color.blue > color.green + 100;
      green += color.green > color.red + 100 && color.green > color.blue + 100;
    }
  }
  EXPECT_GT(red + blue, 2000u);
  EXPECT_NEAR(static_cast<double>(red), static_cast<double>(blue), 0.1 * (red + blue));
  EXPECT_LT(green, (red + blue) / 30) << "the mesh itself, where it is drawn through them";
  viewFromAbove(0, 0, 2000.0);  // a face is 10 pixels wide
  const Image near = grab();
  near.save(osmesa_harness::resultsFolder() + "/labels_levels_near.png");
  EXPECT_LT(near.count(GREEN), 10u);
  EXPECT_TRUE(near.at(320, 200).blue < 60 && near.at(320, 200).red > 150) << near.at(320, 200);
  EXPECT_TRUE(near.at(320, 280).red < 60 && near.at(320, 280).blue > 150) << near.at(320, 280);
  overlay->removeLabel("wall_2");
  uploadAll(*overlay);
  EXPECT_GT(grab().at(320, 280).green, 150) << "the mesh";
}

// A label of few faces is never drawn in parts.
TEST_F(LabelOverlayTest, of_labels_in_parts_and_others_on_the_same_faces_the_last_is_seen)
{
  constexpr std::uint32_t FINE = 230;
  const auto mesh = flatGrid(FINE);
  drawMesh(mesh);
  overlay->setMesh(mesh);
  const auto block = [](std::uint32_t size) {  // around the center
    std::vector<std::uint32_t> faces;
    for (std::uint32_t row = FINE / 2; row < FINE / 2 + size; ++row) {
      const std::uint32_t first = 2 * (row * FINE + FINE / 2);
      for (std::uint32_t face = first; face < first + 2 * size; ++face) {
        faces.push_back(face);
      }
    }
    return faces;
  };
  label("other", rows(FINE, 0, FINE), {0, 255, 255, 255});
  for (const bool red_below : {true, false}) {
    label("tree_1", block(13), red_below ? RED_COLOR : BLUE_COLOR);
    label("tree_2", block(11), red_below ? BLUE_COLOR : RED_COLOR);
    uploadAll(*overlay);
    viewFromAbove(0.05, 0.05, 1000.0);  // a face is 9 pixels wide
    const Image image = grab();
    const std::size_t below = image.count(red_below ? RED : BLUE);
    const std::size_t above = image.count(red_below ? BLUE : RED);
    EXPECT_NEAR(static_cast<double>(above) / (above + below), 121.0 / 169.0, 0.02)
        << (red_below ? "blue" : "red") << " is above";
  }
}

TEST_F(LabelOverlayTest, faces_beyond_the_mesh_are_left_out)
{
  EXPECT_EQ(put(*overlay, {"early", {0, 1}}), 2u) << "without a mesh";
  EXPECT_TRUE(overlay->upload());
  overlay->setMesh(flatGrid(CELLS));
  overlay->setColor("a", RED_COLOR);
  EXPECT_EQ(put(*overlay, {"a", {0, 1, 200, 4294967295u}}), 2u);
  EXPECT_EQ(picture().count(RED), 400u);
  EXPECT_EQ(put(*overlay, {"a", {200}}), 1u);
  EXPECT_EQ(picture().count(RED), 0u);
}

TEST_F(LabelOverlayTest, faces_that_change_faster_than_they_are_uploaded_show_as_well)
{
  constexpr std::uint32_t FINE = 400;
  overlay->setMesh(flatGrid(FINE));
  overlay->setColor("a", RED_COLOR);
  for (std::uint32_t i = 0; i <= 40; ++i) {
    put(*overlay, {"a", rows(FINE, i, FINE - i)});
    EXPECT_FALSE(overlay->upload(std::chrono::microseconds(0))) << "a slice";
  }
  viewFromAbove();
  for (std::uint32_t i = 0; i < 5000 && grab().count(RED) == 0; ++i) {
    put(*overlay, {"a", rows(FINE, i % 40, FINE - i % 40)});
    EXPECT_FALSE(overlay->upload(std::chrono::microseconds(0))) << "a slice";
  }
  EXPECT_GT(grab().count(RED), 0u) << "some of those before";
  put(*overlay, {"a", rows(FINE, 40, FINE - 40)});
  EXPECT_NEAR(static_cast<double>(picture().count(RED)), 200.0 * 160, 400.0)
      << "the last, to a pixel at its ends";
}

TEST_F(LabelOverlayTest, labels_move_with_their_pose)
{
  overlay->setMesh(flatGrid(CELLS));
  label("a", rows(CELLS, 0, 1), RED_COLOR);
  overlay->place(rviz_mesh_plugin::FramePose{
      {1.0f, 0.5f, 0.0f}, {Ogre::Radian(Ogre::Math::HALF_PI), Ogre::Vector3::UNIT_Z}});
  const Image image = picture();
  EXPECT_EQ(image.count(RED), ROW);
  // The row y = -0.9 is now the column x = 1.9.
  EXPECT_EQ(image.at(320 + 190, 240 - 50), RED);
}

TEST_F(LabelOverlayTest, what_is_out_of_sight_is_not_drawn)
{
  overlay->setMesh(flatGrid(100));
  label("left", {0, 1, 2, 3}, RED_COLOR);
  label("right", {198, 199}, BLUE_COLOR);
  uploadAll(*overlay);
  const auto triangles = [&](double x) {
    viewFromAbove(x, -1.0, 1000.0);
    grab();
    return panel()->getRenderWindow()->getStatistics().triangleCount;
  };
  const auto none = triangles(20.0);
  EXPECT_EQ(triangles(-1.0), none + 4);
  EXPECT_EQ(triangles(1.0), none + 2);
}

TEST_F(LabelOverlayTest, labels_stay_in_front_of_a_mesh_that_is_drawn_with_less_detail)
{
  constexpr std::uint32_t FINE = 300;
  // Bumps of some faces each, which are not there any more where it has less detail.
  const auto mesh = rviz_mesh_plugin::convert(test_meshes::terrain(
      FINE, [](double x, double y) { return 0.02 * std::sin(200.0 * x) * std::sin(180.0 * y); }));
  drawMesh(mesh);
  overlay->setMesh(mesh);
  label("all", rows(FINE, 0, FINE), RED_COLOR);
  uploadAll(*overlay);
  for (const bool parallel : {false, true}) {
    const auto reddish = [&] {
      if (parallel) {
        viewFromAbove(0.0, 0.0, 40.0);
      } else {
        lookAt({5.0, -3.8, 5.0}, {0.0, 0.0, 0.0});
      }
      const Image image = grab();
      std::size_t red = 0;
      std::size_t green = 0;
      for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) {
          red += image.at(x, y).red > image.at(x, y).green + 20 ? 1 : 0;
          green += image.at(x, y).green > image.at(x, y).red + 20 ? 1 : 0;
        }
      }
      EXPECT_LT(green, red / 50) << "parallel: " << parallel;
      return red;
    };
    style.level_of_detail = true;
    visual->setStyle(style);
    const std::size_t coarse = reddish();
    EXPECT_GT(coarse, 3000u);
    style.level_of_detail = false;
    visual->setStyle(style);
    const std::size_t fine = reddish();
    EXPECT_NEAR(static_cast<double>(coarse), static_cast<double>(fine), 0.02 * fine);
  }
}

TEST_F(LabelOverlayTest, nothing_is_left_after_many_meshes_and_labels)
{
  overlay.reset();
  spinFrames();
  {
    LabelOverlay warm_up(root);
    warm_up.setMesh(flatGrid(1));
    put(warm_up, {"a", {0}});
    uploadAll(warm_up);
    viewFromAbove();
    grab();
  }
  const auto before = counts();
  const auto mesh = flatGrid(CELLS);
  const auto other = flatGrid(5);
  for (int cycle = 0; cycle < 1000; ++cycle) {
    LabelOverlay cycled(root);
    for (int i = 0; i < 3; ++i) {
      cycled.setMesh(i % 2 == 0 ? mesh : other);
      cycled.setColor("a", {static_cast<std::uint8_t>(cycle), 0, 0, 255});
      put(cycled, {"a", {0, 1, 2}});
      put(cycled, {"b", {3}});
      cycled.setPhantom(i == 1);
      cycled.setVisible(cycle % 2 == 0);
      if (cycle % 3 != 0) {
        cycled.upload();
      }
      put(cycled, {"a", rows(5, 0, 4)});
      cycled.removeLabel("b");
    }
  }
  EXPECT_EQ(counts(), before);
}

TEST_F(LabelOverlayTest, ten_thousand_labels_are_drawn)
{
  constexpr std::uint32_t FINE = 100;
  const auto mesh = flatGrid(FINE);
  overlay->setMesh(mesh);
  const auto start = std::chrono::steady_clock::now();
  for (std::uint32_t i = 0; i < 10000; ++i) {
    const std::uint8_t shade = i % 2 == 0 ? 255 : 250;
    label("cell_" + std::to_string(i), {2 * i, 2 * i + 1}, {shade, 0, 0, 255});
  }
  const auto made = std::chrono::steady_clock::now();
  Image image = picture();
  EXPECT_EQ(image.count(RED, 5), 10 * ROW);
  EXPECT_EQ(image.count(RED), 5 * ROW);
  const auto drawing = std::chrono::steady_clock::now();
  grab();
  const auto end = std::chrono::steady_clock::now();
  const auto milliseconds = [](auto duration) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(duration).count();
  };
  RecordProperty("ms_to_make", static_cast<int>(milliseconds(made - start)));
  RecordProperty("ms_per_grab", static_cast<int>(milliseconds(end - drawing)));
}
