#include <algorithm>
#include <array>
#include <optional>
#include <random>

#include <osmesa_harness/image_compare.h>

#include "base/vectors.h"
#include "picking/view_geometry.h"
#include "selection/face_neighbors.h"
#include "selection/selection_visual.h"
#include "selection_tool_fixture.h"

using rviz_mesh_plugin::SurfaceIndex;

class SelectionStepsTest : public SelectionToolFixture
{
 protected:
  /// With the brush, from one place of the cursor to another without any between.
  void jump(const Pixel& a, const Pixel& b)
  {
    press(a, Qt::LeftButton, Qt::ControlModifier);
    move(b, Qt::ControlModifier);
    release(b, Qt::ControlModifier);
  }

  /// What is under the straight way from one place of the cursor to another; "no" where nothing is.
  std::vector<std::optional<rviz_mesh_plugin::SurfaceHit>> under(const Pixel& a, const Pixel& b,
                                                                 int samples)
  {
    std::vector<std::optional<rviz_mesh_plugin::SurfaceHit>> hits;
    for (int i = 0; i <= samples; ++i) {
      const double share = i / static_cast<double>(samples);
      const auto ray = rviz_mesh_plugin::rayThrough(
          {a.x + 0.5 + share * (b.x - a.x), a.y + 0.5 + share * (b.y - a.y)}, *viewport());
      hits.push_back(picker.pick(ray).hit);
    }
    return hits;
  }

  /// All that is within half a radius of the way is selected, and nothing that is not within one.
  void expectPainted(const Pixel& a, const Pixel& b, double radius)
  {
    const auto mesh = shown().mesh;
    std::vector<bool> near(mesh->faceCount(), false);
    std::optional<std::array<double, 3>> last;
    for (const auto& hit : under(a, b, 16 * 256)) {
      if (!hit || (last && rviz_mesh_plugin::distance(*last, hit->point) < 0.05 * radius)) {
        continue;
      }
      last = hit->point;
      for (const auto face : touching(*mesh, mesh_map::SphereRegion(hit->point, 0.45 * radius))) {
        EXPECT_TRUE(tool->selection().contains(face)) << face;
      }
      for (const auto face : touching(*mesh, mesh_map::SphereRegion(hit->point, 1.1 * radius))) {
        near[face] = true;
      }
    }
    for (const auto face : selected()) {
      EXPECT_TRUE(near[face]) << face;
    }
  }
};

TEST_F(SelectionStepsTest, the_brush_leaves_no_gaps_and_a_stroke_is_one_step)
{
  showTerrain(60);
  const double radius = static_cast<double>(0.08f);
  choose("Brush Radius", 0.08f);
  for (int view = 0; view < 3; view += 2) {
    takeView(view);
    key(Qt::Key_Delete);
    const Pixel a{220, 190}, b{400, 290};
    press(a, Qt::LeftButton, Qt::ControlModifier);
    release(b, Qt::ControlModifier);
    expectPainted(a, b, radius);
    key(Qt::Key_Z, Qt::ControlModifier);
    EXPECT_TRUE(selected().empty());
    key(Qt::Key_Y, Qt::ControlModifier);
    EXPECT_FALSE(selected().empty());
  }
}

TEST_F(SelectionStepsTest, a_brush_smaller_than_a_pixel_paints_all_of_a_long_way)
{
  showTerrain(60);
  takeView(2);
  choose("Brush Radius", 0.004f);
  const Pixel a{120, 200}, b{520, 270};
  jump(a, b);
  ASSERT_TRUE(settle());
  std::size_t on_the_way = 0;
  for (const auto& hit : under(a, b, b.x - a.x)) {
    EXPECT_TRUE(!hit || tool->selection().contains(hit->face)) << on_the_way;
    on_the_way += hit ? 1 : 0;
  }
  EXPECT_GT(on_the_way, 200u);
}

TEST_F(SelectionStepsTest, the_brush_leaves_no_gaps_where_a_pixel_is_longer_than_it)
{
  showPrepared(test_meshes::terrain(80, [](double, double) { return 0.0; }));
  lookAt({2.5, 0.0, 0.06}, {0.0, 0.0, 0.0});  // along the floor
  spinFrames();
  const auto mesh = shown().mesh;
  choose("Brush Radius", 0.02f);
  std::vector<rviz_mesh_plugin::SurfaceHit> floor;
  for (int y = 0; y < 480; ++y) {
    if (const auto hit = picker.pick(mouse(320, y)).hit) {
      floor.push_back(*hit);
    }
  }
  ASSERT_GT(floor.size(), 4u);
  ASSERT_GT(rviz_mesh_plugin::distance(floor[0].point, floor[1].point), 0.1)
      << "five times the radius";
  int top = 0;
  while (!picker.pick(mouse(320, top)).hit) {
    ++top;
  }
  jump({320, top}, {320, top + 3});
  ASSERT_TRUE(settle());
  // On a plane, the way is straight.
  for (int i = 0; i <= 1000; ++i) {
    std::array<double, 3> point;
    for (unsigned k = 0; k < 3; ++k) {
      point[k] = floor[0].point[k] + (floor[3].point[k] - floor[0].point[k]) * i / 1000.0;
    }
    for (const auto face : touching(*mesh, mesh_map::SphereRegion(point, 0.01))) {
      ASSERT_TRUE(tool->selection().contains(face)) << i;
    }
  }
}

TEST_F(SelectionStepsTest, the_brush_invents_nothing_over_a_gap)
{
  auto message = test_meshes::terrain(40, [](double x, double) { return x < 0.0 ? -0.6 : 0.0; });
  auto& faces = message.mesh_geometry.faces;
  const auto& vertices = message.mesh_geometry.vertices;
  faces.erase(std::remove_if(faces.begin(), faces.end(),
                             [&](const auto& face) {
                               double left = 1e3, right = -1e3;
                               for (const auto vertex : face.vertex_indices) {
                                 left = std::min(left, vertices[vertex].x);
                                 right = std::max(right, vertices[vertex].x);
                               }
                               return right > -0.4 && left < 0.2;
                             }),
              faces.end());
  showPrepared(message);
  choose("Brush Radius", 0.06f);
  lookAt({1.5, -2.0, 2.0}, {0, 0, 0});
  spinFrames();
  const auto row = under({0, 240}, {DEFAULT_WIDTH - 1, 240}, DEFAULT_WIDTH - 1);
  const auto isHit = [](const auto& hit) { return hit.has_value(); };
  const auto first = std::find_if(row.begin(), row.end(), isHit);
  const auto last = std::find_if(row.rbegin(), row.rend(), isHit).base() - 1;
  ASSERT_LT(first, last);
  ASSERT_GT(std::count_if(first, last, [](const auto& hit) { return !hit; }), 20)
      << "there is a gap";
  const Pixel a{static_cast<int>(first - row.begin()) + 10, 240};
  const Pixel b{static_cast<int>(last - row.begin()) - 10, 240};
  jump(a, b);
  ASSERT_TRUE(settle());
  EXPECT_GT(selected().size(), 20u);
  expectPainted(a, b, static_cast<double>(0.06f));
}

TEST_F(SelectionStepsTest, the_brush_takes_what_is_seen_as_one_step)
{
  showTerrain();
  lookAt({3.5, -2.5, 1.0}, {0.3, -0.2, 0.4});
  spinFrames();
  choose("Brush Radius", 0.4f);
  const std::vector<Pixel> path{{250, 240}, {320, 250}, {400, 230}};
  drag(path, Qt::LeftButton, Qt::ControlModifier);
  const Faces through = selected();
  key(Qt::Key_Z, Qt::ControlModifier);
  choose("Selection", "Visible Only");
  drag(path, Qt::LeftButton, Qt::ControlModifier);
  EXPECT_TRUE(tool->busy());
  ASSERT_TRUE(settle());
  const Faces seen = selected();
  EXPECT_GT(seen.size(), 10u);
  EXPECT_LT(seen.size(), through.size());
  EXPECT_TRUE(std::includes(through.begin(), through.end(), seen.begin(), seen.end()));
  EXPECT_FALSE(tool->selection().inStroke());
  drag({path[1]}, Qt::RightButton, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_LT(selected().size(), seen.size());
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(selected(), seen);
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_TRUE(selected().empty());
}

TEST_F(SelectionStepsTest, thousand_random_operations_are_undone_and_redone)
{
  showTerrain(12);
  takeView(0);
  std::mt19937 random(7);
  const auto number = [&](int below) {
    return static_cast<int>(random() % static_cast<unsigned>(below));
  };
  const auto pixel = [&] { return Pixel{200 + number(240), 140 + number(200)}; };
  choose("Brush Radius", 0.2f);
  ASSERT_TRUE(spinUntil(
      [&] { return SurfaceIndex::instance().findNeighbors(shown().mesh).neighbors != nullptr; }));
  click({318, 236});
  std::vector<Faces> states{{}, selected()};
  while (states.size() < 1000) {
    const auto button = number(2) ? Qt::LeftButton : Qt::RightButton;
    switch (number(7)) {
      case 0:
        click(pixel(), button);
        break;
      case 1:
      case 2:
        drag({pixel(), pixel()}, button);
        break;
      case 3:
        drag({pixel(), pixel(), pixel()}, button, Qt::ControlModifier);
        break;
      case 4:
        key(number(2) ? Qt::Key_Plus : Qt::Key_Minus);
        break;
      case 5:
        key(Qt::Key_I, Qt::ControlModifier);
        break;
      default:
        drag({pixel(), pixel()}, button);
        press(pixel(), button, Qt::ControlModifier);
        key(Qt::Key_Escape);
        release(pixel(), Qt::ControlModifier);
        break;
    }
    if (selected() != states.back()) {
      states.push_back(selected());
    }
  }
  for (std::size_t i = states.size(); i-- > 0;) {
    ASSERT_EQ(selected(), states[i]) << i;
    key(Qt::Key_Z, Qt::ControlModifier);
  }
  EXPECT_FALSE(tool->selection().canUndo());
  EXPECT_TRUE(says("nothing to undo")) << said.toStdString();
  for (const Faces& state : states) {
    ASSERT_EQ(selected(), state);
    key(Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
  }
  EXPECT_FALSE(tool->selection().canRedo());
}

TEST_F(SelectionStepsTest, is_seen_while_dragging_and_afterwards)
{
  showTerrain();
  takeView(0);
  const auto before = grab();
  drag({{250, 180}, {330, 240}});
  press({350, 200});
  move({450, 330});
  const auto box = grab();
  box.save(osmesa_harness::resultsFolder() + "/selection_box.png");
  EXPECT_NEAR(box.at(350, 270).red, 255, 40) << "its border is light";
  EXPECT_NEAR(box.at(350, 270).blue, 255, 40);
  key(Qt::Key_Escape);
  release({450, 330});
  EXPECT_TRUE(says("Given up")) << said.toStdString();
  key(Qt::Key_2);
  press(LASSO[0]);
  for (const Pixel& at : LASSO) {
    move(at);
  }
  grab().save(osmesa_harness::resultsFolder() + "/selection_lasso.png");
  tool->deactivate();
  release(LASSO[0]);
  tool->activate();
  choose("Brush Radius", 0.25f);
  press({400, 260}, Qt::LeftButton, Qt::ControlModifier);
  grab().save(osmesa_harness::resultsFolder() + "/selection_brush.png");
  tool->deactivate();
  const auto after = grab();
  after.save(osmesa_harness::resultsFolder() + "/selection_after.png");
  const auto hit = picker.pick(mouse(290, 210)).hit;
  ASSERT_TRUE(hit && tool->selection().contains(hit->face));
  EXPECT_GT(after.at(290, 210).red, after.at(290, 210).blue + 60) << "another tool is in use";
  EXPECT_EQ(after.at(400, 300).red, before.at(400, 300).red) << "the stroke was given up";
}
