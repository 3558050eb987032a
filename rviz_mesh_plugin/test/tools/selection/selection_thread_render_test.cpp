#include "selection/face_neighbors.h"
#include "selection/selection_visual.h"
#include "selection_tool_fixture.h"

using rviz_mesh_plugin::ClusterLabelTool;
using rviz_mesh_plugin::SurfaceIndex;

/// A mesh of so many faces that a box over all of it is not for the GUI thread.
class SelectionThreadTest : public SelectionToolFixture
{
 protected:
  void SetUp() override
  {
    SelectionToolFixture::SetUp();
    display = showTerrain(230);
    lookAt({5, -4, 4}, {0.3, -0.2, 0.4});
    spinFrames();
    ASSERT_TRUE(spinUntil(
        [&] { return SurfaceIndex::instance().findNeighbors(shown().mesh).neighbors != nullptr; }));
    face_count = shown().mesh->faceCount();
  }

  void selectAllByBox(Qt::MouseButton button = Qt::LeftButton) { drag({A, B}, button); }

  Display* display = nullptr;
  std::size_t face_count = 0;
  const Pixel A{5, 5}, B{634, 474};
};

TEST_F(SelectionThreadTest, many_faces_are_looked_for_on_a_thread_and_few_at_once)
{
  selectAllByBox();
  EXPECT_TRUE(tool->busy());
  EXPECT_TRUE(selected().empty());
  EXPECT_TRUE(says("Looking for the faces")) << said.toStdString();
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), face_count);
  drag({{310, 235}, {318, 242}}, Qt::RightButton);
  EXPECT_FALSE(tool->busy());
  EXPECT_LT(selected().size(), face_count);
  choose("Brush Radius", 3.0f);
  press({320, 240}, Qt::LeftButton, Qt::ControlModifier);
  EXPECT_TRUE(tool->busy()) << "a brush as large as the mesh";
  release({320, 240}, Qt::ControlModifier);
  ASSERT_TRUE(settle());
  EXPECT_EQ(selected().size(), face_count);
  EXPECT_FALSE(tool->selection().inStroke());
  key(Qt::Key_Minus);
  EXPECT_TRUE(tool->busy()) << "there are many to be looked at";
  ASSERT_TRUE(settle());
  key(Qt::Key_Plus);
  EXPECT_TRUE(tool->busy());
  ASSERT_TRUE(settle());
}

TEST_F(SelectionThreadTest, edits_that_come_meanwhile_are_made_in_their_order)
{
  choose("Brush Radius", 0.2f);
  const std::vector<std::function<void()>> steps{
      [&] { selectAllByBox(); },
      [&] { key(Qt::Key_I, Qt::ControlModifier); },
      [&] {
        click({320, 240});
      },
      [&] {
        drag({{300, 220}, {340, 250}}, Qt::LeftButton, Qt::ControlModifier);
      },
      [&] { key(Qt::Key_Plus); },
      [&] { key(Qt::Key_I, Qt::ControlModifier); },
      [&] { key(Qt::Key_Plus); },
      [&] {
        drag({{100, 100}, {300, 300}}, Qt::RightButton);
      },
      [&] { selectAllByBox(Qt::RightButton); },
      [&] { key(Qt::Key_Z, Qt::ControlModifier); },
      [&] { key(Qt::Key_Z, Qt::ControlModifier); },
      [&] { key(Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier); }};
  const auto statesAfter = [&](bool one_by_one) {
    for (const auto& step : steps) {
      step();
      if (one_by_one) {
        EXPECT_TRUE(settle());
      } else {
        EXPECT_TRUE(tool->busy() && selected().empty()) << "nothing before its turn";
      }
    }
    EXPECT_TRUE(settle());
    std::vector<Faces> states;
    for (; tool->selection().canUndo(); key(Qt::Key_Z, Qt::ControlModifier)) {
      states.push_back(selected());
    }
    EXPECT_TRUE(selected().empty());
    return states;
  };
  const auto expected = statesAfter(true);
  ASSERT_EQ(expected.size(), 8u);
  const auto states = statesAfter(false);
  ASSERT_EQ(states.size(), expected.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    EXPECT_TRUE(states[i] == expected[i])
        << i << ": " << states[i].size() << " faces instead of " << expected[i].size();
  }
}

// While no frame comes, nothing that has been found is taken.
TEST_F(SelectionThreadTest, moves_of_a_large_brush_are_looked_for_together)
{
  choose("Brush Radius", 1.2f);
  const auto strokeAfter = [&](bool one_by_one) {
    press({200, 240}, Qt::LeftButton, Qt::ControlModifier);
    for (int x = 204; x < 400; x += 4) {
      move({x, 240}, Qt::ControlModifier);
      EXPECT_LE(tool->waiting(), 2u) << "the one that has begun, and the next";
      if (one_by_one) {
        EXPECT_TRUE(settle());
      }
    }
    EXPECT_EQ(tool->waiting(), one_by_one ? 0u : 2u);
    release({400, 240}, Qt::ControlModifier);
    EXPECT_TRUE(settle());
    const Faces faces = selected();
    key(Qt::Key_Z, Qt::ControlModifier);
    EXPECT_TRUE(selected().empty()) << "one step";
    return faces;
  };
  const Faces expected = strokeAfter(true);
  EXPECT_GT(expected.size(), 10000u);
  EXPECT_TRUE(strokeAfter(false) == expected);
}

TEST_F(SelectionThreadTest, escape_gives_up_all_that_waits)
{
  click({320, 240});
  const Faces before = selected();
  selectAllByBox();
  key(Qt::Key_I, Qt::ControlModifier);
  key(Qt::Key_Z, Qt::ControlModifier);
  press({300, 240}, Qt::LeftButton, Qt::ControlModifier);
  move({320, 260}, Qt::ControlModifier);
  ASSERT_TRUE(tool->busy());
  key(Qt::Key_Escape);
  EXPECT_FALSE(tool->busy());
  EXPECT_TRUE(says("Given up")) << said.toStdString();
  release({320, 260}, Qt::ControlModifier);
  spinFrames(10);
  EXPECT_EQ(selected(), before);
  EXPECT_FALSE(tool->selection().inStroke());
  key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_TRUE(selected().empty()) << "one step, as before";
  EXPECT_FALSE(tool->selection().canUndo());
}

TEST_F(SelectionThreadTest, clearing_gives_up_the_first_search_as_well)
{
  ASSERT_FALSE(tool->mesh()) << "it has not been given one in any frame";
  selectAllByBox();
  ASSERT_TRUE(tool->busy());
  tool->clearSelection();
  EXPECT_FALSE(tool->busy());
  spinFrames(10);
  EXPECT_TRUE(selected().empty());
}

TEST_F(SelectionThreadTest, nothing_is_labelled_before_its_faces_are_known)
{
  int requested = 0;
  QObject::connect(tool.get(), &ClusterLabelTool::labelRequested, [&] { ++requested; });
  click({320, 240});
  selectAllByBox();
  key(Qt::Key_Return);
  EXPECT_EQ(requested, 0);
  EXPECT_TRUE(tool->busy());
  ASSERT_TRUE(settle());
  key(Qt::Key_Return);
  EXPECT_EQ(requested, 1);
  EXPECT_EQ(selected().size(), face_count);
}

TEST_F(SelectionThreadTest, what_waits_is_dropped_with_its_mesh)
{
  tool->update(0.03f, 0.03f);
  click({320, 240});
  selectAllByBox();
  key(Qt::Key_I, Qt::ControlModifier);
  ASSERT_TRUE(tool->busy());
  delete display;
  spinFrames();
  EXPECT_FALSE(tool->busy());
  EXPECT_TRUE(selected().empty());
  EXPECT_FALSE(tool->visual()->mesh());
  EXPECT_TRUE(says("The mesh is gone of which 1 faces were selected")) << said.toStdString();
}

TEST_F(SelectionThreadTest, the_highlight_of_many_faces_is_made_on_a_thread)
{
  tool->update(0.03f, 0.03f);
  spinFrames(10);
  key(Qt::Key_A, Qt::ControlModifier);
  EXPECT_EQ(selected().size(), face_count) << "of bits, it does not take long";
  EXPECT_EQ(tool->visual()->uploadedBytes(), 0u);
  EXPECT_FALSE(tool->visual()->isCurrent());
  EXPECT_TRUE(says("being highlighted")) << said.toStdString();
  ASSERT_TRUE(spinUntil([&] { return tool->visual()->isCurrent(); }));
  EXPECT_GE(tool->visual()->uploadedBytes(), 12 * face_count);
  spinFrames();
  EXPECT_FALSE(says("being highlighted")) << said.toStdString();
  click({320, 240}, Qt::RightButton);
  ASSERT_TRUE(spinUntil([&] { return tool->visual()->isCurrent(); }));
  const std::size_t uploaded = tool->visual()->uploadedBytes();
  click({323, 243}, Qt::RightButton);
  EXPECT_EQ(selected().size(), face_count - 2);
  ASSERT_TRUE(spinUntil([&] { return tool->visual()->isCurrent(); }));
  EXPECT_LT(tool->visual()->uploadedBytes() - uploaded, 8192u * 24) << "one part of it";
  key(Qt::Key_Delete);
  EXPECT_TRUE(tool->visual()->isCurrent());
  EXPECT_LT(tool->visual()->gpuBytes(), 24 * shown().mesh->vertexCount() + 1000);
}

/// Which is found out on a thread, once somebody asks.
TEST_F(SelectionThreadTest, what_has_to_know_the_neighbors_of_faces_waits_for_them)
{
  const std::vector<std::function<void()>> ways{[&] {
                                                  click({320, 240});
                                                  for (int i = 0; i < 4; ++i) {
                                                    key(Qt::Key_Plus);
                                                  }
                                                  key(Qt::Key_Minus);
                                                },
                                                [&] {
                                                  choose("Mode", "Flood");
                                                  click({320, 240});
                                                  key(Qt::Key_Plus);
                                                }};
  for (const auto& way : ways) {
    Faces faces[2];
    for (const bool known : {true, false}) {
      key(Qt::Key_Delete);
      ASSERT_TRUE(settle());
      if (!known) {
        SurfaceIndex::instance().clear();
        waitUntilPrepared();
      }
      way();
      EXPECT_TRUE(known || tool->busy());
      ASSERT_TRUE(settle());
      faces[known ? 1 : 0] = selected();
    }
    EXPECT_GT(faces[1].size(), 13u);
    EXPECT_EQ(faces[0].size(), faces[1].size());
    EXPECT_TRUE(faces[0] == faces[1]);
  }
  SurfaceIndex::instance().clear();
  waitUntilPrepared();
  const Faces before = selected();
  key(Qt::Key_Plus);
  key(Qt::Key_Escape);
  EXPECT_FALSE(tool->busy());
  spinFrames();
  EXPECT_EQ(selected(), before);
}
