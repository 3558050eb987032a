#include <random>

#include <osmesa_harness/image_compare.h>

#include "selection/face_neighbors.h"
#include "selection/selection_visual.h"
#include "selection_tool_fixture.h"

using rviz_mesh_plugin::SurfaceIndex;

class SelectionStepsTest : public SelectionToolFixture
{
};

TEST_F(SelectionStepsTest, the_brush_leaves_no_gaps_and_a_stroke_is_one_step)
{
  showTerrain(60);
  const auto mesh = shown().mesh;
  const double radius = static_cast<double>(0.08f);
  choose("Brush Radius", 0.08f);
  for (int view = 0; view < 3; view += 2) {
    takeView(view);
    key(Qt::Key_Delete);
    const Pixel a{220, 190}, b{400, 290};
    press(a, Qt::LeftButton, Qt::ControlModifier);
    release(b, Qt::ControlModifier);
    std::vector<bool> near(mesh->faceCount(), false);
    for (int i = 0; i <= 400; ++i) {
      const auto hit =
          picker.pick(mouse(a.x + (b.x - a.x) * i / 400, a.y + (b.y - a.y) * i / 400)).hit;
      if (!hit) {
        continue;
      }
      for (const auto face : touching(*mesh, mesh_map::SphereRegion(hit->point, 0.5 * radius))) {
        EXPECT_TRUE(tool->selection().contains(face)) << i;
      }
      for (const auto face : touching(*mesh, mesh_map::SphereRegion(hit->point, 1.1 * radius))) {
        near[face] = true;
      }
    }
    for (const auto face : selected()) {
      EXPECT_TRUE(near[face]);
    }
    key(Qt::Key_Z, Qt::ControlModifier);
    EXPECT_TRUE(selected().empty());
    key(Qt::Key_Y, Qt::ControlModifier);
    EXPECT_FALSE(selected().empty());
  }
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
