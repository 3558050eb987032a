#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>

#include "rendering/labels/label_overlay.h"
#include "selection/selection_visual.h"
#include "support/label_fixture.h"
#include "support/tool_fixture.h"

using osmesa_harness::Image;
using osmesa_harness::isNear;
using osmesa_harness::Rgb;
using rviz_mesh_plugin::FaceSelection;
using rviz_mesh_plugin::LabelOverlay;
using rviz_mesh_plugin::MeshDataConstPtr;
using rviz_mesh_plugin::SelectionVisual;

namespace {

constexpr std::size_t FACE_BYTES = 12;

/// A share of orange over a color that faces the camera.
Rgb blended(const Rgb& below)
{
  const auto& color = SelectionVisual::COLOR;
  const auto mix = [&](int over, int under) {
    return static_cast<std::uint8_t>((over * color.alpha + under * (255 - color.alpha)) / 255);
  };
  return {mix(color.red, below.red), mix(color.green, below.green), mix(color.blue, below.blue)};
}

}  // namespace

class SelectionVisualTest : public ToolFixture
{
 protected:
  void SetUp() override
  {
    ToolFixture::SetUp();
    visual = makeVisual();
  }

  void TearDown() override
  {
    visual.reset();
    ToolFixture::TearDown();
  }

  static std::unique_ptr<SelectionVisual> makeVisual()
  {
    return std::make_unique<SelectionVisual>(sceneManager()->getRootSceneNode());
  }

  void setMesh(const MeshDataConstPtr& mesh)
  {
    visual->setMesh(mesh);
    selection.reset(mesh->faceCount());
    while (!visual->upload(std::chrono::microseconds(0))) {
    }
  }

  /// How many bytes a change uploads.
  std::size_t apply(const FaceSelection::Change& change)
  {
    const std::size_t before = visual->uploadedBytes();
    visual->apply(selection, change);
    return visual->uploadedBytes() - before;
  }

  /// Whether the surface ends near this pixel, or one begins behind another.
  bool isOutline(int x, int y) const
  {
    double nearest = 1e9, farthest = 0.0;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {2, 0}, {-2, 0}, {0, 2}, {0, -2}}) {
      const auto hit = picker.pick(mouse(x + dx, y + dy)).hit;
      nearest = std::min(nearest, hit ? hit->distance : 1e6);
      farthest = std::max(farthest, hit ? hit->distance : 1e6);
    }
    return farthest - nearest > 0.1;
  }

  /// Of a display of hills in a frame that lies anywhere.
  Display* showHills(std::uint32_t cells, const FixedPose& pose)
  {
    putFrame("hills", pose);
    auto* display = createMeshDisplay();
    auto message = test_meshes::terrain(
        cells, [](double x, double y) { return 0.3 * std::sin(4 * x) * std::cos(3 * y); });
    message.header.frame_id = "hills";
    EXPECT_TRUE(show(display, message));
    waitUntilPrepared();
    return display;
  }

  std::unique_ptr<SelectionVisual> visual;
  FaceSelection selection;
};

TEST_F(SelectionVisualTest, exactly_the_pixels_of_the_selected_faces_change)
{
  showHills(20, {{0.2, -0.1, 0.3}, {0.9, 0.1, -0.2, 0.4}});
  const auto mesh = picker.meshes().at(0).mesh;
  setMesh(mesh);
  std::mt19937 random(3);
  for (int view = 0; view < 3; ++view) {
    if (view == 0) {
      viewFromAbove(0.2, -0.1, 150.0);
    } else {
      lookAt({2.0, -1.5, view == 1 ? 1.5 : -1.5}, {0.2, -0.1, 0.3});
    }
    apply(selection.clear());
    ASSERT_TRUE(visual->follow(picker.meshes(), selection));
    const Image before = grab();
    FaceSelection::Faces faces;
    for (std::uint32_t face = 0; face < mesh->faceCount(); ++face) {
      if (random() % 3 == 0) {
        faces.push_back(face);
      }
    }
    apply(selection.select(faces));
    ASSERT_TRUE(visual->follow(picker.meshes(), selection));
    const Image after = grab();
    EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("selection_" + std::to_string(view), after));
    std::size_t changed = 0, wrong = 0, unsure = 0;
    for (int y = 0; y < after.height(); y += 2) {
      for (int x = 0; x < after.width(); x += 2) {
        const auto hit = picker.pick(mouse(x, y)).hit;
        if (isOutline(x, y) ||
            (hit && *std::min_element(hit->barycentric.begin(), hit->barycentric.end()) < 0.02)) {
          ++unsure;
          continue;
        }
        const bool is_changed = before.at(x, y) != after.at(x, y);
        const bool is_selected = hit && selection.contains(hit->face);
        changed += is_changed;
        wrong += is_changed != is_selected;
      }
    }
    EXPECT_GT(changed, 2000u) << view;
    EXPECT_LE(wrong, 3u) << view;
    EXPECT_LT(unsure, changed) << view;
  }
}

TEST_F(SelectionVisualTest, only_what_changes_is_uploaded)
{
  const auto mesh = test_labels::flatGrid(100);
  setMesh(mesh);
  EXPECT_EQ(apply(selection.selectAll()), mesh->faceCount() * FACE_BYTES);
  EXPECT_EQ(apply(selection.clear()), 0u) << "the buffer stays";
  EXPECT_EQ(apply(selection.select({77})), FACE_BYTES);
  EXPECT_EQ(apply(selection.select({77})), 0u);
  std::mt19937 random(1);
  apply(selection.invert());
  for (int i = 0; i < 500; ++i) {
    FaceSelection::Faces faces;
    for (int n = 0; n < 10; ++n) {
      faces.push_back(random() % mesh->faceCount());
    }
    const FaceSelection::Change change =
        i % 2 == 0 ? selection.select(faces) : selection.deselect(faces);
    const std::size_t count = change.count();
    ASSERT_LE(apply(change), 65 * FACE_BYTES * count);
    if (change.addedCount() > 0) {
      ASSERT_LE(apply(selection.undo()), 65 * FACE_BYTES * count);
    }
  }
  // What grows by little is rarely uploaded anew.
  apply(selection.clear());
  auto other = makeVisual();
  visual.swap(other);
  visual->setMesh(mesh);
  std::size_t uploaded = 0;
  for (std::uint32_t face = 0; face + 20 <= mesh->faceCount(); face += 20) {
    FaceSelection::Faces faces;
    for (std::uint32_t i = face; i < face + 20; ++i) {
      faces.push_back(i);
    }
    uploaded += apply(selection.select(faces));
  }
  EXPECT_LT(uploaded, 7 * mesh->faceCount() * FACE_BYTES);
}

TEST_F(SelectionVisualTest, many_changes_look_as_the_selection_does_as_a_whole)
{
  showHills(20, {});
  setMesh(picker.meshes().at(0).mesh);
  viewFromAbove();
  std::mt19937 random(9);
  for (int i = 0; i < 300; ++i) {
    FaceSelection::Faces faces;
    const std::uint32_t first = random() % 800;
    const std::uint32_t last = first + random() % 60;
    for (std::uint32_t face = first; face < std::min<std::uint32_t>(800, last); ++face) {
      faces.push_back(face);
    }
    switch (random() % 6) {
      case 0:
        apply(selection.replace(faces));
        break;
      case 1:
        apply(selection.deselect(faces));
        break;
      case 2:
        apply(selection.invert());
        break;
      case 3:
        apply(random() % 3 == 0 ? selection.redo() : selection.undo());
        break;
      default:
        apply(selection.select(faces));
    }
  }
  const Image image = grab();
  visual->setSelection(selection);
  EXPECT_TRUE(image == grab()) << selection.count();
  EXPECT_GT(selection.count(), 0u);
}

TEST_F(SelectionVisualTest, it_is_seen_over_labels_and_mesh)
{
  auto* display = createMeshDisplay();
  ASSERT_TRUE(show(display, test_meshes::terrain(10, [](double, double) { return 0.0; })));
  const auto mesh = display->mesh();
  LabelOverlay labels(sceneManager()->getRootSceneNode());
  labels.setMesh(mesh);
  labels.setColor("opaque_1", {255, 0, 0, 255});
  labels.setColor("translucent_1", {0, 0, 255, 100});
  test_labels::put(labels, {"opaque_1", test_labels::rows(10, 0, 3)});
  test_labels::put(labels, {"translucent_1", test_labels::rows(10, 3, 6)});
  while (!labels.upload()) {
  }
  viewFromAbove();
  const Image before = grab();
  setMesh(mesh);
  apply(selection.select(test_labels::rows(10, 1, 8)));
  const Image after = grab();
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("selection_labels", after));
  for (int row = 0; row < 10; ++row) {  // of 20 pixels, from below
    const int y = 330 - 20 * row;
    const Rgb below = before.at(325, y);
    if (row >= 1 && row < 8) {
      EXPECT_TRUE(isNear(after.at(325, y), blended(below), 2))
          << row << ": " << after.at(325, y) << " over " << below;
    } else {
      EXPECT_EQ(after.at(325, y), below) << row;
    }
  }
  visual->setColor({0, 0, 0, 255});
  EXPECT_EQ(grab().at(325, 290), (Rgb{0, 0, 0}));
}

TEST_F(SelectionVisualTest, it_follows_the_mesh_and_is_hidden_with_it)
{
  auto* display = showHills(4, {});
  setMesh(display->mesh());
  apply(selection.selectAll());
  viewFromAbove(0, 0, 50.0);
  const auto orange = [&] {
    visual->follow(picker.meshes(), selection);
    const Image image = grab();
    visual->setVisible(false);
    const Image without = grab();
    std::size_t pixels = 0;
    for (int x = 0; x < image.width(); ++x) {
      pixels += image.at(x, 240) != without.at(x, 240);
    }
    return pixels;
  };
  EXPECT_EQ(orange(), 100u);
  putFrame("hills", {{2.0, 0, 0}, {1, 0, 0, 0}});
  EXPECT_EQ(orange(), 100u);
  visual->follow(picker.meshes(), selection);
  EXPECT_NE(grab().at(420, 240), grab().center()) << "where the mesh is now";
  display->setEnabled(false);
  EXPECT_FALSE(visual->follow(picker.meshes(), selection));
  EXPECT_EQ(grab().count({48, 48, 48}), 640u * 480u);
  display->setEnabled(true);
  spinFrames();
  EXPECT_EQ(orange(), 100u);
}

TEST_F(SelectionVisualTest, many_faces_are_uploaded_in_slices_and_drawn_in_levels_of_detail)
{
  showHills(500, {});
  const auto mesh = picker.meshes().at(0).mesh;
  setMesh(mesh);
  lookAt({0, -14, 10}, {0, 0, 0});
  const Image plain = grab();
  visual->apply(selection, selection.selectAll());
  EXPECT_EQ(visual->uploadedBytes(), 0u) << "not at once";
  std::size_t uploaded = 0, largest = 0, slices = 0;
  ASSERT_TRUE(spinUntil([&] {
    const bool done = visual->upload(std::chrono::microseconds(0));
    largest = std::max(largest, visual->uploadedBytes() - uploaded);
    slices += visual->uploadedBytes() > uploaded ? 1 : 0;
    uploaded = visual->uploadedBytes();
    return done;
  }));
  EXPECT_GE(uploaded, mesh->faceCount() * FACE_BYTES);
  EXPECT_LE(uploaded, 2 * mesh->faceCount() * FACE_BYTES);
  EXPECT_LE(largest, (std::size_t(1) << 20) + 8192 * 2 * FACE_BYTES);
  EXPECT_GE(slices, 5u);
  visual->follow(picker.meshes(), selection);
  const auto save = [](const Image& image, const std::string& name) {
    image.save(osmesa_harness::resultsFolder() + "/selection_levels_" + name + ".png");
  };
  /// Of the pixels that the mesh covers: the part that is highlighted.
  const auto highlighted = [&](const Image& image, const Image& without) {
    std::size_t covered = 0, changed = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        covered += without.at(x, y) != Rgb{48, 48, 48};
        changed += image.at(x, y) != without.at(x, y);
      }
    }
    return static_cast<double>(changed) / static_cast<double>(covered);
  };
  const Image far = grab();
  save(far, "far");
  EXPECT_GT(highlighted(far, plain), 0.97);
  EXPECT_LT(visual->facesDrawn(), mesh->faceCount() / 8);
  EXPECT_GT(visual->facesDrawn(), 1000u);

  FaceSelection::Faces third;
  std::mt19937 random(5);
  for (std::uint32_t face = 0; face < mesh->faceCount(); ++face) {
    if (random() % 3 == 0) {
      third.push_back(face);
    }
  }
  visual->apply(selection, selection.replace(third));
  ASSERT_TRUE(spinUntil([&] { return visual->upload(); }));
  const Image scattered = grab();
  save(scattered, "scattered");
  EXPECT_NEAR(highlighted(scattered, plain), 1.0 / 3.0, 0.12) << "as much of the picture";
  EXPECT_LT(visual->facesDrawn(), mesh->faceCount() / 8);

  FaceSelection::Faces left_half;
  for (std::uint32_t face = 0; face < mesh->faceCount(); ++face) {
    if (mesh->vertices[mesh->indices[3 * face]].position[0] < 0.0f) {
      left_half.push_back(face);
    }
  }
  visual->apply(selection, selection.replace(left_half));
  ASSERT_TRUE(spinUntil([&] { return visual->upload(); }));
  const Image half = grab();
  save(half, "half");
  EXPECT_NEAR(highlighted(half, plain), 0.5, 0.05);
  lookAt({0.01, -0.06, 0.25}, {0, 0, 0.1});
  const Image near = grab();
  save(near, "near");
  std::size_t wrong = 0, right = 0;
  visual->setVisible(false);
  const Image near_plain = grab();
  visual->follow(picker.meshes(), selection);
  for (int y = 4; y < near.height(); y += 8) {
    for (int x = 4; x < near.width(); x += 8) {
      const auto hit = picker.pick(mouse(x, y)).hit;
      if (!hit || isOutline(x, y) ||
          *std::min_element(hit->barycentric.begin(), hit->barycentric.end()) < 0.1) {
        continue;
      }
      const bool changed = near.at(x, y) != near_plain.at(x, y);
      (changed == selection.contains(hit->face) ? right : wrong) += 1;
    }
  }
  EXPECT_GT(right, 500u);
  EXPECT_LE(wrong, 2u) << "near by it is exactly the selected faces";
}

TEST_F(SelectionVisualTest, nothing_is_seen_before_its_vertices_nor_left_after_it)
{
  const auto mesh = test_labels::flatGrid(220);  // of 1.2 MB
  visual->setMesh(mesh);
  selection.reset(mesh->faceCount());
  viewFromAbove();
  EXPECT_FALSE(visual->upload(std::chrono::microseconds(0)));
  apply(selection.selectAll());
  EXPECT_EQ(grab().count({48, 48, 48}), 640u * 480u);
  while (!visual->upload(std::chrono::microseconds(0))) {
  }
  EXPECT_LT(grab().count({48, 48, 48}), 640u * 480u - 30000u);
  EXPECT_EQ(visual->gpuBytes() / 100000, (221u * 221u * 24 + 220u * 220u * 2 * 15) / 100000);
  visual->setMesh(nullptr);
  EXPECT_EQ(visual->gpuBytes(), 0u);
  EXPECT_EQ(apply(selection.clear()), 0u) << "without a mesh";
  EXPECT_TRUE(visual->upload());
  visual.reset();
  spinFrames();
  const auto empty = counts();
  for (int i = 0; i < 10; ++i) {
    visual = makeVisual();
    setMesh(test_labels::flatGrid(20));
    apply(selection.selectAll());
    grab();
    if (i % 2 == 0) {
      visual->setColor({1, 2, 3, 4});
      setMesh(test_labels::flatGrid(10));
    }
    visual.reset();
    spinFrames();
    ASSERT_EQ(counts(), empty) << i;
  }
}
