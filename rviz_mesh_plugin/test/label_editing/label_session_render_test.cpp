#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <rviz/display_context.h>
#include <QString>

#include "label_session_fixture.h"

using namespace std::chrono_literals;
using rviz_mesh_plugin::FileLabels;
using test_labels::rows;

/// Has displays and nothing else, and cannot be used once it is gone.
class DisplaysContext : public rviz::DisplayContext
{
 public:
  explicit DisplaysContext(rviz::DisplayGroup* displays) : displays_(displays) {}
  static void operator delete(void* memory)
  {
    std::memset(memory, 0, sizeof(DisplaysContext));
    ::operator delete(memory);
  }

  rviz::DisplayGroup* getRootDisplayGroup() const override { return displays_; }
  Ogre::SceneManager* getSceneManager() const override { return nullptr; }
  rviz::WindowManagerInterface* getWindowManager() const override { return nullptr; }
  rviz::SelectionManager* getSelectionManager() const override { return nullptr; }
  rviz::FrameManager* getFrameManager() const override { return nullptr; }
  QString getFixedFrame() const override { return {}; }
  uint64_t getFrameCount() const override { return 0; }
  rviz::DisplayFactory* getDisplayFactory() const override { return nullptr; }
  ros::CallbackQueueInterface* getUpdateQueue() override { return nullptr; }
  ros::CallbackQueueInterface* getThreadedQueue() override { return nullptr; }
  void handleChar(QKeyEvent* /*event*/, rviz::RenderPanel* /*panel*/) override {}
  void handleMouseEvent(const rviz::ViewportMouseEvent& /*event*/) override {}
  rviz::ToolManager* getToolManager() const override { return nullptr; }
  rviz::ViewManager* getViewManager() const override { return nullptr; }
  uint32_t getDefaultVisibilityBit() const override { return 0; }
  rviz::BitAllocator* visibilityBits() override { return nullptr; }
  void setStatus(const QString& /*message*/) override {}
  void queueRender() override {}

 private:
  rviz::DisplayGroup* displays_;
};

class LabelSessionTest : public LabelSessionFixture
{
};

TEST_F(LabelSessionTest, a_label_is_unstored_then_unsaved)
{
  start();
  EXPECT_EQ(session->display(), display);
  EXPECT_EQ(session->names(), (std::vector<std::string>{"tree_1", "tree_2", "wall_1"}));
  EXPECT_EQ(session->assign("car_1", {7, 5, 7}), "");
  EXPECT_TRUE(session->isUnstored("car_1"));
  EXPECT_EQ(*session->faces("car_1"), (Faces{5, 7}));
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  EXPECT_TRUE(received(0, "car_1", {5, 7}));
  EXPECT_TRUE(session->isUnstored("car_1")) << "it has not come back";
  EXPECT_TRUE(says(display, "Edits", "Ok: 'car_1' is being stored"));
  ASSERT_TRUE(store(1));
  EXPECT_FALSE(session->isUnstored("car_1"));
  EXPECT_TRUE(spinUntil([&] { return status(display, "Edits").empty(); }));
  EXPECT_TRUE(session->isUnsaved("car_1"));
}

TEST_F(LabelSessionTest, another_one_without_edits_says_nothing_of_them)
{
  start();
  rviz_mesh_plugin::LabelSession other(manager(), 10s);
  other.work(nullptr);
  EXPECT_EQ(session->assign("car_1", {5}), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  for (int frame = 0; frame < 5; ++frame) {
    session->work(nullptr);
    other.work(nullptr);
    spinFrames(1);
  }
  EXPECT_EQ(status(display, "Edits"), "Ok: 'car_1' is being stored");
  ASSERT_TRUE(store(1));
  EXPECT_TRUE(spinUntil([&] { return status(display, "Edits").empty(); }));
}

TEST_F(LabelSessionTest, faces_are_added_and_taken_away_even_before_they_are_stored)
{
  start();
  EXPECT_EQ(session->add("tree_1", rows(10, 4, 5)), "");
  EXPECT_EQ(session->takeAway("tree_1", {0, 1, 2, 199}), "");
  Faces expected = rows(10, 0, 1);
  expected.erase(expected.begin(), expected.begin() + 3);
  const Faces more = rows(10, 4, 5);
  expected.insert(expected.end(), more.begin(), more.end());
  ASSERT_TRUE(store(1));
  EXPECT_TRUE(received(0, "tree_1", expected));
  EXPECT_EQ(session->unstored(), 0u);
  EXPECT_EQ(session->remove({"tree_2"}), "");
  ASSERT_TRUE(store(2));
  EXPECT_TRUE(received(1, "tree_2", {}));
  EXPECT_EQ(session->names(), (std::vector<std::string>{"tree_1", "wall_1"}));
  EXPECT_NE(session->assign("a/b", {1}), "");
  EXPECT_NE(session->assign("a", {200}), "") << "the mesh has 200 faces";
}

TEST_F(LabelSessionTest, renaming_stores_the_new_one_with_its_color_before_the_old_one_goes)
{
  server->setColors(colorsOf({{"tree_1", {10, 20, 30}}}));
  start();
  ASSERT_TRUE(until([&] { return session->content()().at("tree_1").color.has_value(); }));
  EXPECT_NE(session->rename("tree_1", "wall_1").find("already"), std::string::npos);
  EXPECT_EQ(session->rename("tree_1", "bush_7"), "");
  ASSERT_TRUE(store(1));
  EXPECT_TRUE(received(0, "bush_7", rows(10, 0, 1)));
  ASSERT_TRUE(until([&] { return server->colorsSet().size() == 1; }));
  EXPECT_EQ(server->colorsSet()[0].label, "bush_7");
  EXPECT_EQ(server->colorsSet()[0].color.g, 20 / 255.0f);
  EXPECT_EQ(server->edits().size(), 1u) << "the color is not stored";
  server->colors.publish(colorsOf({{"tree_1", {10, 20, 30}}, {"bush_7", {10, 20, 30}}}));
  ASSERT_TRUE(store(2));
  EXPECT_TRUE(received(1, "tree_1", {}));
  EXPECT_EQ(session->unstored(), 0u);
  EXPECT_EQ(session->names(), (std::vector<std::string>{"bush_7", "tree_2", "wall_1"}));
}

TEST_F(LabelSessionTest, merging_stores_all_faces_before_the_others_go)
{
  start();
  EXPECT_EQ(session->merge({"tree_1", "tree_2", "wall_1"}, "tree_2"), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  spinFrames(5);
  session->work(nullptr);
  EXPECT_EQ(server->edits().size(), 1u) << "the others stay until it is stored";
  ASSERT_TRUE(store(1));
  Faces others = rows(10, 0, 1);
  const Faces wall = rows(10, 2, 3);
  others.insert(others.end(), wall.begin(), wall.end());
  EXPECT_TRUE(received(0, "tree_2", others, false)) << "what others add to it stays";
  EXPECT_EQ(*session->faces("tree_2"), rows(10, 0, 3));
  ASSERT_TRUE(store(3));
  EXPECT_TRUE(received(1, "tree_1", {}));
  EXPECT_TRUE(received(2, "wall_1", {}));
  EXPECT_EQ(session->unstored(), 1u) << "tree_1 has not come back";
}

TEST_F(LabelSessionTest, merging_back_before_anything_was_sent_stores_what_was_asked_for_last)
{
  start();
  EXPECT_EQ(session->merge({"tree_1", "tree_2"}, "tree_2"), "");
  EXPECT_EQ(session->merge({"tree_1", "tree_2"}, "tree_1"), "");
  EXPECT_EQ(*session->faces("tree_1"), rows(10, 0, 2));
  ASSERT_TRUE(answerAll());
  EXPECT_TRUE(received(0, "tree_1", rows(10, 0, 2)));
  EXPECT_TRUE(received(1, "tree_2", {}));
  EXPECT_EQ(*session->faces("tree_1"), rows(10, 0, 2));
  EXPECT_EQ(session->names(), (std::vector<std::string>{"tree_1", "wall_1"}));
}

TEST_F(LabelSessionTest, merging_back_what_was_sent_stores_what_was_asked_for_last_however_late)
{
  start();
  EXPECT_EQ(session->merge({"tree_1", "tree_2"}, "tree_2"), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  EXPECT_EQ(session->merge({"tree_1", "tree_2"}, "tree_1"), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 2; })) << "it waits for itself";
  EXPECT_TRUE(received(1, "tree_1", rows(10, 0, 2)));
  ASSERT_TRUE(answerAll());
  EXPECT_TRUE(received(2, "tree_2", {}));
  EXPECT_EQ(*session->faces("tree_1"), rows(10, 0, 2));
  EXPECT_EQ(session->names(), (std::vector<std::string>{"tree_1", "wall_1"}));
  EXPECT_EQ(session->undo(), "undone: merging 2 labels into 'tree_1'");
  ASSERT_TRUE(answerAll());
  EXPECT_EQ(*session->faces("tree_2"), rows(10, 0, 2)) << "as after the first time";
  EXPECT_EQ(session->names(), (std::vector<std::string>{"tree_2", "wall_1"}));
}

TEST_F(LabelSessionTest, merging_back_what_was_renamed_keeps_faces_and_color_at_any_moment)
{
  server->setColors(colorsOf({{"tree_1", {10, 20, 30}}}));
  start();
  ASSERT_TRUE(until([&] { return session->content()().at("tree_1").color.has_value(); }));
  EXPECT_EQ(session->rename("tree_1", "bush_7"), "");
  EXPECT_EQ(session->merge({"tree_1", "bush_7"}, "tree_1"), "") << "nothing is sent yet";
  ASSERT_TRUE(answerAll());
  EXPECT_EQ(*session->faces("tree_1"), rows(10, 0, 1));
  EXPECT_EQ(session->names(), (std::vector<std::string>{"tree_1", "tree_2", "wall_1"}));
  ASSERT_TRUE(until([&] { return server->edits().size() == 2; })) << "both are as they were";
  EXPECT_EQ(session->rename("tree_1", "bush_7"), "");
  ASSERT_TRUE(store(3));
  server->colors.publish(colorsOf({{"tree_1", {10, 20, 30}}, {"bush_7", {10, 20, 30}}}));
  ASSERT_TRUE(until([&] { return server->edits().size() == 4; }));
  EXPECT_TRUE(received(3, "tree_1", {}));
  EXPECT_EQ(session->merge({"tree_1", "bush_7"}, "tree_1"), "") << "the old one is about to go";
  const std::size_t colors = server->colorsSet().size();
  ASSERT_TRUE(until([&] { return server->colorsSet().size() > colors; }))
      << "its color goes with it, and is set again";
  EXPECT_EQ(server->colorsSet().back().label, "tree_1");
  EXPECT_EQ(server->colorsSet().back().color.g, 20 / 255.0f);
  ASSERT_TRUE(answerAll());
  EXPECT_EQ(*session->faces("tree_1"), rows(10, 0, 1));
  EXPECT_EQ(session->names(), (std::vector<std::string>{"tree_1", "tree_2", "wall_1"}));
}

TEST_F(LabelSessionTest, merging_back_does_not_overwrite_what_others_have_changed)
{
  start();
  EXPECT_EQ(session->rename("tree_1", "bush_7"), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  ASSERT_TRUE(publish(LabelServer::cluster("tree_1", {3, 150})));
  EXPECT_EQ(session->merge({"tree_1", "bush_7"}, "tree_1"), "");
  ASSERT_TRUE(until([&] { return session->failed() == 1; }));
  EXPECT_NE(session->failure().find("'tree_1' is not stored: it has changed meanwhile"),
            std::string::npos)
      << session->failure();
  EXPECT_EQ(server->edits().size(), 1u) << "the other one stays, too";
}

TEST_F(LabelSessionTest, an_edit_that_is_lost_fails_and_is_sent_again)
{
  start(1ms);
  session->assign("car_1", {5});
  ASSERT_TRUE(until([&] { return session->failed() == 1; }));
  EXPECT_NE(session->failure().find("'car_1' is not stored: it was sent, but"), std::string::npos);
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  session->sendAgain();
  ASSERT_TRUE(until([&] { return server->edits().size() == 2; }));
  EXPECT_TRUE(received(1, "car_1", {5}));
  ASSERT_TRUE(store(2));
  EXPECT_EQ(session->unstored(), 0u);
  EXPECT_EQ(session->failure(), "");
}

/// As while somebody who stores labels is started again: it hears of edits before all are connected
/// that it tells.
TEST_F(LabelSessionTest, an_edit_that_is_stored_without_a_message_is_found_by_asking)
{
  start(6s);
  session->assign("car_1", {5});
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  server->addLabel("car_1", {5});
  ASSERT_TRUE(until([&] { return session->unstored() == 0 || session->failed() > 0; }));
  EXPECT_EQ(session->failure(), "");
  EXPECT_EQ(session->unsaved(), 1u);
  EXPECT_EQ(display->labels().at("car_1")->faces, Faces{5});
}

TEST_F(LabelSessionTest, where_nobody_listens_edits_are_kept)
{
  start(60s, false);
  EXPECT_EQ(session->assign("car_1", {5}), "");
  session->work(nullptr);
  EXPECT_NE(session->failure().find("nobody stores labels"), std::string::npos)
      << session->failure();
  EXPECT_EQ(*session->faces("car_1"), Faces{5});
  server->listen(name_space);
  ASSERT_TRUE(until([&] {
    session->sendAgain();
    return server->edits().size() == 1;
  }));
  ASSERT_TRUE(store(1));
  EXPECT_EQ(session->unstored(), 0u);
}

TEST_F(LabelSessionTest, edits_survive_their_display)
{
  start();
  session->assign("car_1", {5});
  delete display;
  session->work(nullptr);
  EXPECT_FALSE(session->display());
  EXPECT_EQ(session->unstored(), 1u);
  EXPECT_NE(session->failure().find("no display shows"), std::string::npos) << session->failure();
  EXPECT_NE(session->assign("car_2", {5}), "");
  display = createLabels();
  ASSERT_TRUE(says(display, "Labels", "3 labels"));
  ASSERT_TRUE(until([&] {
    session->sendAgain();
    return !server->edits().empty();
  }));
  EXPECT_TRUE(received(0, "car_1", {5}));
}

/// As in a program whose window outlives its view, after the panel.
TEST_F(LabelSessionTest, edits_survive_the_context_of_their_display)
{
  start();
  auto context = std::make_unique<DisplaysContext>(manager()->getRootDisplayGroup());
  session = std::make_unique<rviz_mesh_plugin::LabelSession>(context.get());
  session->work(nullptr);
  ASSERT_EQ(session->display(), display);
  EXPECT_EQ(session->assign("car_1", {5}), "");
  context.reset();
  delete display;
  session->work(nullptr);
  EXPECT_EQ(session->unstored(), 1u);
  EXPECT_NE(session->failure().find("no display shows"), std::string::npos) << session->failure();
  EXPECT_NE(session->assign("car_2", {5}), "");
}

TEST_F(LabelSessionTest, many_labels_arrive_all)
{
  start();
  FileLabels labels;
  for (std::uint32_t i = 0; i < 60; ++i) {
    labels["car_" + std::to_string(i)].faces = {i};
  }
  EXPECT_EQ(session->import(std::make_shared<const rviz_mesh_plugin::FileLabels>(labels)), "");
  for (std::size_t stored = 0; session->unstored() > 0; ++stored) {
    ASSERT_TRUE(until([&] { return server->edits().size() > stored; }));
    server->labels.publish(server->edits()[stored].cluster);
    ASSERT_TRUE(until([&] { return session->unstored() == 59 - stored; }));
  }
  EXPECT_EQ(session->content()().size(), 63u);
}

TEST_F(LabelSessionTest, what_goes_to_everybody_anyway_is_sent_once)
{
  name_space.clear();
  server = std::make_unique<LabelServer>(name_space);
  start();
  session->assign("car_1", {5});
  ASSERT_TRUE(store(1));
  session->assign("car_2", {5});
  ASSERT_TRUE(store(2));
  EXPECT_TRUE(until([&] { return copies.size() >= 2; }));
  EXPECT_EQ(copies, (std::vector<std::string>{"meshcar_1", "meshcar_2"}));
}

TEST_F(LabelSessionTest, everybody_hears_of_labels_of_a_mesh_with_a_name_of_its_own)
{
  start();
  session->assign("car_1", {5});  // of "mesh", which is any mesh elsewhere
  ASSERT_TRUE(store(1));
  auto garden = test_meshes::square();
  garden.uuid = "garden";
  geometry.publish(garden);
  ASSERT_TRUE(until([&] { return session->mesh()->uuid == "garden"; }));
  EXPECT_NE(session->assign("car_1", {5}), "") << "the garden has 2 faces";
  EXPECT_EQ(session->assign("car_1", {1}), "");
  EXPECT_TRUE(until([&] { return copies == std::vector<std::string>{"gardencar_1"}; }));
  ASSERT_TRUE(until([&] { return server->edits().size() == 2; }));
  EXPECT_EQ(server->edits()[1].uuid, "garden");
  // That a label has gone would make one without faces, where its owner has deleted it before.
  EXPECT_EQ(session->remove({"car_1"}), "");
  EXPECT_EQ(session->assign("car_2", {0}), "");
  EXPECT_TRUE(until([&] { return copies.size() >= 2; }));
  EXPECT_EQ(copies, (std::vector<std::string>{"gardencar_1", "gardencar_2"}));
}
