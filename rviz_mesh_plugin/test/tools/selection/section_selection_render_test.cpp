// What has been cut away is neither pointed at nor selected, and hides nothing.
#include <cmath>
#include <set>

#include "mesh_view/selectable_faces.h"
#include "picking/view_geometry.h"
#include "selection/selection_visual.h"
#include "selection_tool_fixture.h"

using rviz_mesh_plugin::Combination;
using rviz_mesh_plugin::SelectableFaces;
using rviz_mesh_plugin::SurfaceIndex;

class SectionSelectionTest : public SelectionToolFixture
{
 protected:
  Display* showStoreys()
  {
    Display* display = createMeshDisplay();
    EXPECT_TRUE(show(display, storeys()));
    waitUntilPrepared();
    EXPECT_TRUE(spinUntil(
        [&] { return SurfaceIndex::instance().findNeighbors(shown().mesh).neighbors != nullptr; }));
    viewFromAbove();
    spinFrames();
    return display;
  }

  static void cut(Display* display, const char* limit, float value)
  {
    set(display, {"Section", limit}, value);
    set(display, {"Section"}, true);
  }

  Faces keepSelectable(Faces faces) const
  {
    SelectableFaces(shown()).keep(faces);
    return faces;
  }

  std::size_t ofRoof() const
  {
    const Faces faces = selected();
    return faces.end() - std::lower_bound(faces.begin(), faces.end(), 800u);
  }

  const Pixel A{180, 110}, B{430, 350};
};

TEST_F(SectionSelectionTest, a_click_goes_through_to_what_is_drawn)
{
  Display* display = showStoreys();
  EXPECT_GE(picker.pick(mouse(320, 240)).hit->face, 800u);
  cut(display, "Max Height", 0.5f);
  const auto hit = picker.pick(mouse(320, 240)).hit;
  ASSERT_TRUE(hit);
  EXPECT_LT(hit->face, 800u);
  EXPECT_NEAR(hit->point[2], 0.1 * std::sin(5 * hit->point[0]), 0.02);
  // As far as without the section, but for the storey: 1 m of a bumpy roof.
  set(display, {"Section"}, false);
  const double above = picker.pick(mouse(320, 240)).hit->distance;
  EXPECT_NEAR(hit->distance, above + 1.0, 0.01) << "from the camera, not from the section";
  cut(display, "Max Height", 5.0f);
  cut(display, "Max X", 0.5f);
  EXPECT_TRUE(picker.pick(mouse(365, 240)).hit);
  EXPECT_FALSE(picker.pick(mouse(375, 240)).hit) << "that part of the mesh is not there";
}

TEST_F(SectionSelectionTest, box_lasso_and_brush_take_what_is_drawn_seen_or_not)
{
  Display* display = showStoreys();
  choose("Brush Radius", 3.0f);
  const std::vector<std::function<void()>> ways{
      [&] {
        drag({A, B});
      },
      [&] {
        choose("Mode", "Lasso");
        drag(LASSO);
        choose("Mode", "Box");
      },
      [&] {
        drag({{300, 220}, {330, 250}}, Qt::LeftButton, Qt::ControlModifier);
      }};
  for (std::size_t way = 0; way < ways.size(); ++way) {
    set(display, {"Section"}, false);
    key(Qt::Key_Delete);
    ways[way]();
    ASSERT_TRUE(settle());
    const Faces whole = selected();
    EXPECT_GT(ofRoof(), 100u) << way;
    cut(display, "Max Height", 0.5f);
    cut(display, "Min X", -0.3f);
    key(Qt::Key_Delete);
    ways[way]();
    ASSERT_TRUE(settle());
    EXPECT_EQ(selected(), keepSelectable(whole)) << way;
    EXPECT_EQ(ofRoof(), 0u);
    EXPECT_GT(selected().size(), 100u);
    EXPECT_LT(selected().size(), whole.size() / 2);
  }
}

TEST_F(SectionSelectionTest, what_is_cut_away_hides_nothing)
{
  Display* display = showStoreys();
  choose("Selection", "Visible Only");
  drag({A, B});
  ASSERT_TRUE(settle());
  EXPECT_EQ(ofRoof(), selected().size()) << "the roof hides the floor";
  EXPECT_GT(selected().size(), 300u);
  cut(display, "Max Height", 0.5f);
  for (const char* mode : {"Box", "Lasso"}) {
    choose("Mode", mode);
    key(Qt::Key_Delete);
    drag(std::string(mode) == "Box" ? std::vector<Pixel>{A, B} : LASSO);
    ASSERT_TRUE(settle());
    EXPECT_EQ(ofRoof(), 0u) << mode;
    EXPECT_GT(selected().size(), 300u) << mode;
  }
  // Halfway up the roof: where a face is cut, the eye looks past the part that is gone.
  choose("Mode", "Box");
  cut(display, "Max Height", 1.0f);
  key(Qt::Key_Delete);
  drag({A, B});
  ASSERT_TRUE(settle());
  EXPECT_GT(ofRoof(), 100u);
  EXPECT_GT(selected().size() - ofRoof(), 100u) << "below the waves that are cut off";
}

TEST_F(SectionSelectionTest, flood_and_growing_stop_at_its_border)
{
  Display* display = showStoreys();
  cut(display, "Max Height", 0.5f);
  cut(display, "Max X", 0.2f);
  choose("Mode", "Flood");
  choose("Flood Angle", 90.0f);
  click({300, 240});
  ASSERT_TRUE(settle());
  const Faces all = keepSelectable(SelectableFaces(shown()).bits().faces());
  EXPECT_EQ(selected(), all);
  EXPECT_LT(all.size(), 600u);
  key(Qt::Key_Plus);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected(), all) << "nothing beyond";
  key(Qt::Key_Delete);
  choose("Mode", "Box");
  click({300, 240});
  key(Qt::Key_Plus);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), 4u) << "within it, as ever";
}

TEST_F(SectionSelectionTest, all_and_inverted_are_those_in_it)
{
  Display* display = showStoreys();
  cut(display, "Max Height", 0.5f);
  tool->update(0.03f, 0.03f);
  key(Qt::Key_A, Qt::ControlModifier);
  EXPECT_TRUE(tool->busy()) << "which ones are, the thread finds out";
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), 800u);
  EXPECT_EQ(ofRoof(), 0u);
  drag({A, B}, Qt::RightButton);
  ASSERT_TRUE(settle());
  const std::size_t left = selected().size();
  key(Qt::Key_I, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), 800u - left);
  EXPECT_EQ(ofRoof(), 0u);
  tool->selectBy(shown().mesh, rviz_mesh_plugin::HeightCriterion(), Combination::REPLACE);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), 800u) << "of any height, in the section";
  set(display, {"Section"}, false);
  key(Qt::Key_I, Qt::ControlModifier);
  EXPECT_EQ(ofRoof(), 800u) << "all of it can be selected again";
}

TEST_F(SectionSelectionTest, the_highlight_is_cut_with_the_mesh)
{
  Display* display = showStoreys();
  tool->update(0.03f, 0.03f);
  key(Qt::Key_A, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  const auto orange = [&] {
    const auto image = grab();
    int count = 0;
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        count += image.at(x, y).red > 120 ? 1 : 0;
      }
    }
    return count;
  };
  ASSERT_TRUE(spinUntil([&] { return orange() > 39000; }));
  cut(display, "Max X", 0.0f);
  EXPECT_NEAR(orange(), 20000, 400);
  EXPECT_EQ(selected().size(), 1600u) << "what was selected stays so";
}
