// Labels on hidden faces, their names, and the normals of hidden faces.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/hidden_faces.h"
#include "rendering/labels/label_parts.h"
#include "support/label_display_fixture.h"
#include "support/label_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::Rgb;
using rviz_mesh_plugin::FaceBits;
using test_labels::colorOf;
using test_labels::ROW;
using test_labels::rows;

class HiddenLabelsTest : public LabelDisplayFixture
{
 protected:
  using Names = std::vector<std::string>;

  void TearDown() override
  {
    if (mesh) {
      rviz_mesh_plugin::setHiddenFaces(*mesh, nullptr);
    }
    LabelDisplayFixture::TearDown();
  }

  DisplayFixture::Display* showMesh(std::uint32_t cells = 10)
  {
    auto* display = createMeshDisplay();
    EXPECT_TRUE(show(display, test_meshes::terrain(cells, [](double, double) { return 0.0; })));
    mesh = display->mesh();
    viewFromAbove();
    return display;
  }

  void hide(const std::vector<std::uint32_t>& faces)
  {
    rviz_mesh_plugin::setHiddenFaces(*mesh, std::make_shared<const rviz_mesh_plugin::HiddenFaces>(
                                                FaceBits(mesh->faceCount(), faces)));
  }

  testing::AssertionResult seen(const Rgb& color, std::size_t pixels)
  {
    std::size_t now = 0;
    const bool matches = spinUntil([&] {
      now = grab().count(color);
      return now == pixels;
    });
    return matches ? testing::AssertionSuccess()
                   : testing::AssertionFailure() << now << " pixels are " << color;
  }

  rviz_mesh_plugin::MeshDataConstPtr mesh;
};

TEST_F(HiddenLabelsTest, labels_are_hidden_with_their_faces)
{
  server->addLabel("tree_1", rows(10, 0, 4));
  server->addLabel("wall_1", rows(10, 6, 8));
  auto* display = showMesh();
  auto* labels = createLabels();
  ASSERT_TRUE(says(labels, "Labels", "2 labels"));
  ASSERT_TRUE(seen(colorOf("tree"), 4 * ROW));
  hide(rows(10, 2, 7));
  EXPECT_TRUE(seen(colorOf("tree"), 2 * ROW));
  EXPECT_TRUE(seen(colorOf("wall"), ROW));
  EXPECT_TRUE(seen({0, 255, 0}, 2 * ROW)) << "the mesh itself, where it has no label";
  server->labels.publish(LabelServer::cluster("tree_1", rows(10, 0, 3)));
  server->labels.publish(LabelServer::cluster("wall_1", rows(10, 3, 6)));
  EXPECT_TRUE(seen(colorOf("wall"), 0)) << "a label that comes later, all hidden";
  EXPECT_TRUE(seen(colorOf("tree"), 2 * ROW));
  hide({});
  EXPECT_TRUE(seen(colorOf("wall"), 3 * ROW));
  EXPECT_TRUE(seen(colorOf("tree"), 3 * ROW));
  // The same, drawn by the display of the mesh.
  labels->setEnabled(false);
  set(display, {"Show Labels", "Labels Topic"}, (name_space + "/new_cluster_label").c_str());
  set(display, {"Show Labels"}, true);
  ASSERT_TRUE(seen(colorOf("tree"), 4 * ROW));
  hide(rows(10, 0, 3));
  EXPECT_TRUE(seen(colorOf("tree"), ROW));
}

TEST_F(HiddenLabelsTest, large_labels_too)
{
  const std::uint32_t cells = 260;
  ASSERT_GT(2 * cells * cells, rviz_mesh_plugin::MANY_FACES);
  server->addLabel("tree_1", rows(cells, 0, cells));
  showMesh(cells);
  auto* labels = createLabels();
  ASSERT_TRUE(says(labels, "Labels", "1 label"));
  const auto isWhole = [&] { return grab().count(colorOf("tree")) > 9.9 * ROW; };
  ASSERT_TRUE(spinUntil(isWhole));
  hide(rows(cells, 0, cells / 2));
  ASSERT_TRUE(spinUntil([&] { return grab().count(colorOf("tree")) < 6 * ROW; }));
  EXPECT_NEAR(static_cast<double>(grab().count(colorOf("tree"))), 5 * ROW, 200 * 3);
  hide({});
  EXPECT_TRUE(spinUntil(isWhole));
}

TEST_F(HiddenLabelsTest, names_stand_over_what_is_shown)
{
  server->addLabel("tree_1", rows(10, 0, 4));
  server->addLabel("wall_1", rows(10, 6, 8));
  showMesh();
  auto* labels = createLabels();
  set(labels, {"Show Names"}, true);
  ASSERT_TRUE(spinUntil([&] {
    grab();
    return labels->drawnNames().size() == 2;
  }));
  hide(rows(10, 5, 9));
  EXPECT_TRUE(spinUntil([&] {
    grab();
    return labels->drawnNames() == Names{"tree_1"};
  }));
  hide(rows(10, 5, 7));
  EXPECT_TRUE(spinUntil([&] {
    grab();
    return labels->drawnNames().size() == 2;
  })) << "a part of it is shown";
}

TEST_F(HiddenLabelsTest, the_shade_of_the_mesh_has_no_hidden_faces)
{
  auto* display = showMesh();
  auto* labels = createLabels();
  set(labels, {"Show Phantom"}, true);
  ASSERT_TRUE(says(labels, "Geometry", "200 faces"));
  display->setEnabled(false);
  const auto shade = [&] {
    const Image image = grab();
    std::size_t count = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        count += image.at(x, y) != image.at(5, 5) ? 1 : 0;
      }
    }
    return count;
  };
  ASSERT_TRUE(spinUntil([&] { return shade() == 10 * ROW; })) << shade();
  hide(rows(10, 0, 3));
  EXPECT_TRUE(spinUntil([&] { return shade() == 7 * ROW; })) << shade();
}

TEST_F(HiddenLabelsTest, hidden_faces_have_no_normals)
{
  auto* display = showMesh();
  set(display, {"Show Normals"}, true);
  set(display, {"Show Normals", "Normals Scaling Factor"}, 0.2f);
  lookAt({0, -6, 0.5}, {0, 0, 0.5});
  const auto magenta = [&] { return grab().count(Rgb{255, 0, 255}); };
  std::size_t whole = 0;
  ASSERT_TRUE(spinUntil([&] { return (whole = magenta()) > 100; }));
  for (const char* type : {"Fixed Color", "Vertex Costs"}) {
    set(display, {"Display Type"}, type);
    hide(rows(10, 0, 9));
    EXPECT_TRUE(spinUntil([&] { return 2 * magenta() < whole; })) << type << magenta();
    EXPECT_GT(magenta(), 0u) << "of those that are shown";
    hide(rows(10, 0, 10));
    EXPECT_TRUE(spinUntil([&] { return magenta() == 0; })) << type;
    hide({});
    EXPECT_TRUE(spinUntil([&] { return magenta() == whole; })) << type;
  }
}

TEST_F(HiddenLabelsTest, a_larger_mesh_does_not_have_those_of_the_one_before)
{
  showMesh();
  auto* labels = createLabels();
  set(labels, {"Show Phantom"}, true);
  ASSERT_TRUE(says(labels, "Geometry", "200 faces"));
  hide(rows(10, 0, 3));
  spinFrames();
  geometry.publish(test_meshes::terrain(260, [](double, double) { return 0.0; }));
  ASSERT_TRUE(says(labels, "Geometry", "135200 faces"));
  server->labels.publish(LabelServer::cluster("tree_1", rows(260, 0, 260)));
  ASSERT_TRUE(says(labels, "Labels", "135200 faces"));
  set(labels, {"Show Phantom"}, false);
  EXPECT_TRUE(spinUntil([&] { return grab().count(colorOf("tree")) > 9.9 * ROW; }));
}
