// Edits of labels are undone by edits.
#include <string>
#include <vector>

#include "label_session_fixture.h"
#include "rendering/labels/label_parts.h"

using rviz_mesh_plugin::MANY_FACES;
using rviz_mesh_plugin::Rgba8;
using test_labels::rows;

class LabelSessionUndoTest : public LabelSessionFixture
{
 protected:
  bool failsWith(const std::string& text) const
  {
    return session->failure().find(text) != std::string::npos;
  }

  /// Takes an edit of a color as stored.
  bool colorStored(const std::string& label, const Rgba8& color)
  {
    server->colors.publish(colorsOf({{label, {color.red, color.green, color.blue}}}));
    return until([&] { return display->ownColor(label) == color; });
  }
};

TEST_F(LabelSessionUndoTest, what_was_assigned_is_put_back_by_an_edit)
{
  start();
  EXPECT_EQ(session->undo(), "there is nothing to undo");
  EXPECT_EQ(session->assign("tree_1", {7, 5}), "");
  ASSERT_TRUE(store(1));
  EXPECT_EQ(session->undo(), "undone: labelling 'tree_1'");
  EXPECT_EQ(*session->faces("tree_1"), rows(10, 0, 1));
  ASSERT_TRUE(store(2));
  EXPECT_TRUE(received(1, "tree_1", rows(10, 0, 1)));
  EXPECT_EQ(session->unstored(), 0u) << session->failure();
  EXPECT_EQ(session->undo(), "there is nothing to undo");
  EXPECT_EQ(session->redo(), "done again: labelling 'tree_1'");
  ASSERT_TRUE(store(3));
  EXPECT_TRUE(received(2, "tree_1", {5, 7}));
  EXPECT_EQ(session->redo(), "there is nothing to redo");
}

TEST_F(LabelSessionUndoTest, an_edit_that_is_not_stored_yet_can_be_undone)
{
  start();
  EXPECT_EQ(session->add("tree_1", {150}), "");
  EXPECT_EQ(session->takeAway("wall_1", {40}), "");
  EXPECT_EQ(session->undo(), "undone: taking faces away from 'wall_1'");
  EXPECT_EQ(session->undo(), "undone: adding faces to 'tree_1'");
  EXPECT_EQ(*session->faces("tree_1"), rows(10, 0, 1));
  EXPECT_EQ(*session->faces("wall_1"), rows(10, 2, 3));
  EXPECT_TRUE(until([&] { return session->unstored() == 0; })) << session->failure();
}

TEST_F(LabelSessionUndoTest, many_faces_that_may_still_be_stored_are_not_taken_back_and_stay_a_step)
{
  start();
  ASSERT_TRUE(showLarge());
  EXPECT_EQ(session->assign("ground_1", allOfLarge()), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  const std::string told = session->undo();
  EXPECT_NE(told.find("'ground_1' is on its way"), std::string::npos) << told;
  EXPECT_EQ(session->faceCount("ground_1"), 125000u);
  server->labels.publish(after(server->edits()[0]));
  ASSERT_TRUE(until([&] { return session->unstored() == 0; })) << session->failure();
  EXPECT_EQ(session->undo(), "undone: labelling 'ground_1'");
  ASSERT_TRUE(until([&] { return server->edits().size() == 2; }));
  EXPECT_TRUE(received(1, "ground_1", {}));
}

TEST_F(LabelSessionUndoTest, a_new_edit_leaves_nothing_to_redo_without_a_tool)
{
  start();
  EXPECT_EQ(session->assign("tree_1", {7}), "");
  ASSERT_TRUE(store(1));
  EXPECT_EQ(session->undo(), "undone: labelling 'tree_1'");
  ASSERT_TRUE(store(2));
  EXPECT_EQ(session->assign("wall_1", {8}), "");
  ASSERT_TRUE(store(3));
  EXPECT_EQ(session->redo(), "there is nothing to redo");
}

TEST_F(LabelSessionUndoTest, edits_that_wait_are_kept_while_another_mesh_is_there)
{
  start();
  ASSERT_TRUE(showLarge());
  EXPECT_EQ(session->assign("ground_1", allOfLarge()), "");
  EXPECT_EQ(session->assign("wall_7", {3}), "");
  auto garden = test_meshes::square();
  garden.uuid = "garden";
  geometry.publish(garden);
  ASSERT_TRUE(spinUntil([&] { return display->mesh()->uuid == "garden"; }));
  ASSERT_TRUE(until([&] { return !session->busy(); }));
  EXPECT_EQ(session->unstored(), 2u) << session->failure();
  EXPECT_EQ(session->failed(), 2u) << "both wait for their mesh";
  EXPECT_TRUE(failsWith("no display shows the labels of its mesh"));
  EXPECT_EQ(session->undo(), "there is nothing to undo") << "of this mesh";
  ASSERT_TRUE(showLarge());
  ASSERT_TRUE(until([&] {
    return session->faceCount("wall_7") == 1 && session->faceCount("ground_1") == 125000;
  })) << session->failure();
}

TEST_F(LabelSessionUndoTest, renaming_is_undone_without_losing_faces_on_the_way)
{
  start();
  EXPECT_EQ(session->rename("tree_1", "bush_7"), "");
  ASSERT_TRUE(store(1));
  ASSERT_TRUE(store(2));
  EXPECT_EQ(session->unstored(), 0u) << session->failure();
  EXPECT_EQ(session->undo(), "undone: renaming 'tree_1' to 'bush_7'");
  ASSERT_TRUE(store(3));
  EXPECT_TRUE(received(2, "tree_1", rows(10, 0, 1))) << "the old one first";
  ASSERT_TRUE(store(4));
  EXPECT_TRUE(received(3, "bush_7", {}));
  EXPECT_EQ(session->unstored(), 0u) << session->failure();
  EXPECT_EQ(session->names(), (std::vector<std::string>{"tree_1", "tree_2", "wall_1"}));
}

TEST_F(LabelSessionUndoTest, a_deleted_label_is_there_again)
{
  start();
  EXPECT_EQ(session->remove({"tree_1", "tree_2"}), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 2; }));
  ASSERT_TRUE(publish(LabelServer::cluster("tree_1", {})));
  ASSERT_TRUE(publish(LabelServer::cluster("tree_2", {})));
  EXPECT_EQ(session->unstored(), 0u) << session->failure();
  EXPECT_EQ(session->undo(), "undone: deleting 2 labels");
  ASSERT_TRUE(until([&] { return server->edits().size() == 4; }));
  EXPECT_TRUE(received(2, "tree_1", rows(10, 0, 1)));
  EXPECT_TRUE(received(3, "tree_2", rows(10, 1, 2)));
}

TEST_F(LabelSessionUndoTest, a_color_of_its_own_is_taken_back)
{
  start();
  ASSERT_TRUE(colorStored("tree_1", Rgba8{1, 2, 3, 255}));
  EXPECT_EQ(session->setColor({"tree_1"}, Rgba8{40, 50, 60, 255}), "");
  ASSERT_TRUE(until([&] { return server->colorsSet().size() == 1; }));
  ASSERT_TRUE(colorStored("tree_1", Rgba8{40, 50, 60, 255}));
  ASSERT_TRUE(until([&] { return session->unstored() == 0; }));
  EXPECT_EQ(session->undo(), "undone: coloring 'tree_1'");
  ASSERT_TRUE(until([&] { return server->colorsSet().size() == 2; }));
  const auto color = server->colorsSet()[1].color;
  EXPECT_NEAR(color.r * 255.0f, 1.0f, 0.01f);
  EXPECT_NEAR(color.g * 255.0f, 2.0f, 0.01f);
  EXPECT_NEAR(color.b * 255.0f, 3.0f, 0.01f);
}

TEST_F(LabelSessionUndoTest, what_somebody_else_has_changed_since_is_not_overwritten)
{
  start();
  EXPECT_EQ(session->assign("wall_1", {41}), "");
  ASSERT_TRUE(store(1));
  EXPECT_EQ(session->merge({"tree_1", "tree_2"}, "tree_2"), "");
  ASSERT_TRUE(store(2));
  ASSERT_TRUE(store(3));
  ASSERT_TRUE(publish(LabelServer::cluster("tree_2", {100, 101})));
  const std::string told = session->undo();
  EXPECT_EQ(told,
            "merging 2 labels into 'tree_2' cannot be undone: 'tree_2' has been changed elsewhere "
            "since, and that would be lost; this step is forgotten");
  EXPECT_TRUE(failsWith(told)) << "the panel shows it";
  EXPECT_EQ(session->unstored(), 0u) << "none of its edits is made";
  EXPECT_EQ(session->redo(), "there is nothing to redo");
  EXPECT_EQ(session->undo(), "undone: labelling 'wall_1'") << "the one before";
  ASSERT_TRUE(store(4));
  EXPECT_TRUE(received(3, "wall_1", rows(10, 2, 3)));
  EXPECT_EQ(session->failure(), "");
}

TEST_F(LabelSessionUndoTest, a_change_that_comes_while_an_undo_waits_is_not_overwritten)
{
  start();
  EXPECT_EQ(session->rename("tree_1", "bush_7"), "");
  ASSERT_TRUE(store(1));
  ASSERT_TRUE(store(2));
  EXPECT_EQ(session->undo(), "undone: renaming 'tree_1' to 'bush_7'");
  ASSERT_TRUE(until([&] { return server->edits().size() == 3; }));
  ASSERT_TRUE(publish(LabelServer::cluster("bush_7", {3})));
  ASSERT_TRUE(store(3));
  ASSERT_TRUE(until([&] { return session->failed() == 1; }));
  EXPECT_TRUE(failsWith("'bush_7' is not stored: it has changed meanwhile"));
  EXPECT_EQ(server->edits().size(), 3u);
}

TEST_F(LabelSessionUndoTest, steps_are_of_the_mesh_whose_labels_are_edited)
{
  start();
  EXPECT_EQ(session->assign("tree_1", {7}), "");
  ASSERT_TRUE(store(1));
  auto garden = test_meshes::square();
  garden.uuid = "garden";
  geometry.publish(garden);
  ASSERT_TRUE(until([&] { return session->mesh()->uuid == "garden"; }));
  EXPECT_EQ(session->undo(), "there is nothing to undo");
  publishMesh();
  ASSERT_TRUE(until([&] { return session->mesh()->uuid == "mesh"; }));
  ASSERT_TRUE(until([&] { return session->labels().count("tree_1") == 1; }));
}

// While no work() comes, nothing that the thread has made is taken.
TEST_F(LabelSessionUndoTest, many_faces_are_made_ready_on_a_thread_and_edits_keep_their_order)
{
  start();
  ASSERT_TRUE(showLarge());
  ASSERT_GT(allOfLarge().count(), MANY_FACES);
  EXPECT_EQ(session->assign("ground_1", allOfLarge()), "");
  EXPECT_TRUE(session->busy());
  EXPECT_EQ(session->faceCount("ground_1"), 0u) << "nothing is done before the thread has";
  EXPECT_EQ(session->unstored(), 1u) << "RViz asks before it is closed";
  EXPECT_EQ(session->takeAway("ground_1", {0}), "");
  EXPECT_EQ(session->rename("ground_1", "floor_1"), "");
  EXPECT_EQ(session->unstored(), 3u);
  EXPECT_NE(session->whyNotNow(), "");
  ASSERT_TRUE(until([&] { return !session->busy(); }));
  EXPECT_EQ(session->faceCount("floor_1"), 124999u);
  EXPECT_EQ(session->faceCount("ground_1"), 0u);
  std::size_t answered = 0;
  ASSERT_TRUE(until([&] {
    if (answered < server->edits().size()) {
      server->labels.publish(after(server->edits()[answered++]));
    }
    return session->unstored() == 0;
  }));
  const rviz_mesh_plugin::LabelFacesConstPtr faces = session->faces("floor_1");
  EXPECT_EQ(session->undo(), "undone: renaming 'ground_1' to 'floor_1'");
  EXPECT_TRUE(session->busy()) << "they are compared there, too";
  ASSERT_TRUE(until([&] { return !session->busy(); }));
  EXPECT_EQ(*session->faces("ground_1"), *faces);
}
