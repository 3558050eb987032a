// Labels that are stored are saved in the maps, by whoever has stored them.
#include <string>

#include "label_session_fixture.h"
#include "support/save_server.h"

class LabelSessionSavingTest : public LabelSessionFixture
{
 protected:
  /// Another map, whose labels somebody else stores.
  void startGarden()
  {
    garden_server = std::make_unique<LabelServer>(name_space + "/garden");
    garden_server->listen(name_space + "/garden");
    garden_geometry =
        node.advertise<mesh_msgs::MeshGeometryStamped>(name_space + "/garden/mesh", 1, true);
    auto mesh = test_meshes::terrain(10, [](double, double) { return 0.0; });
    mesh.uuid = "garden";
    garden_geometry.publish(mesh);
    garden = createDisplayAs<Display>("rviz_mesh_plugin/ClusterLabel");
    set(garden, {"Geometry Topic"}, (name_space + "/garden/mesh").c_str());
    set(garden, {"Labels Topic"}, (name_space + "/garden/new_cluster_label").c_str());
    ASSERT_TRUE(untilInGarden(
        [&] { return session->display() == garden && garden_server->labels.getNumSubscribers(); }));
  }

  template <class Done>
  bool untilInGarden(const Done& done)
  {
    return spinUntil([&] {
      session->work(garden->mesh());
      return done();
    });
  }

  /// Labels face 5 of both meshes as car_1 of the one and car_2 of the garden.
  void storeBoth()
  {
    session->work(nullptr);
    ASSERT_EQ(session->display(), display);
    session->assign("car_1", {5});
    ASSERT_TRUE(store(1));
    ASSERT_TRUE(untilInGarden([&] { return session->display() == garden; }));
    session->assign("car_2", {5});
    ASSERT_TRUE(untilInGarden([&] {
      session->sendAgain();
      return !garden_server->edits().empty();
    }));
    garden_server->labels.publish(garden_server->edits()[0].cluster);
    ASSERT_TRUE(untilInGarden([&] { return session->unstored() == 0; }));
    ASSERT_EQ(session->unsaved(), 2u);
  }

  std::unique_ptr<LabelServer> garden_server;
  ros::Publisher garden_geometry;
  Display* garden = nullptr;
};

TEST_F(LabelSessionSavingTest, labels_are_saved_or_it_says_why_not)
{
  start();
  session->assign("car_1", {5});
  ASSERT_TRUE(store(1));
  {
    SaveServer saver(name_space);
    saver.refusal = "the disk is full";
    EXPECT_EQ(session->save(), "");
    EXPECT_NE(session->save(), "") << "while it is saving";
    ASSERT_TRUE(until([&] { return !session->isSaving(); }));
    EXPECT_NE(session->failure().find("the disk is full"), std::string::npos) << session->failure();
    EXPECT_TRUE(session->isUnsaved("car_1"));
    saver.refusal.clear();
    saver.held = true;
    EXPECT_EQ(session->save(), "");
    session->assign("car_2", {6});
    ASSERT_TRUE(store(2));
    EXPECT_TRUE(session->isSaving());
    saver.held = false;
    ASSERT_TRUE(until([&] { return !session->isSaving(); }));
    EXPECT_EQ(session->failure(), "");
    EXPECT_EQ(saver.calls, 2);
    EXPECT_FALSE(session->isUnsaved("car_1"));
    EXPECT_TRUE(session->isUnsaved("car_2")) << "it was stored after that";
  }
  EXPECT_EQ(session->save(), "");
  ASSERT_TRUE(until([&] { return !session->isSaving(); }));
  EXPECT_NE(session->failure().find("nobody offers the service " + name_space + "/save_map"),
            std::string::npos)
      << session->failure();
  EXPECT_TRUE(session->isUnsaved("car_2"));
}

TEST_F(LabelSessionSavingTest, edits_are_followed_where_their_mesh_is_shown)
{
  start();
  startGarden();
  session->work(nullptr);
  session->assign("car_1", {5});
  ASSERT_TRUE(untilInGarden([&] { return server->edits().size() == 1; })) << session->failure();
  EXPECT_EQ(session->display(), garden);
  EXPECT_TRUE(garden_server->edits().empty());
  server->labels.publish(server->edits()[0].cluster);
  ASSERT_TRUE(untilInGarden([&] { return session->unstored() == 0; })) << session->failure();
  EXPECT_EQ(session->unsaved(), 1u);
  EXPECT_FALSE(session->isUnsaved("car_1")) << "it is not in the garden";
  session->work(nullptr);
  EXPECT_TRUE(session->isUnsaved("car_1"));
  session->setColor({"car_1"}, rviz_mesh_plugin::Rgba8{10, 20, 30, 255});
  ASSERT_TRUE(untilInGarden([&] { return server->colorsSet().size() == 1; }));
  server->colors.publish(colorsOf({{"car_1", {10, 20, 30}}}));
  EXPECT_TRUE(untilInGarden([&] { return session->unstored() == 0; }));
  SaveServer saver(name_space);
  SaveServer garden_saver(name_space + "/garden");
  EXPECT_EQ(session->save(), "");
  ASSERT_TRUE(untilInGarden([&] { return !session->isSaving(); }));
  EXPECT_EQ(saver.calls, 1);
  EXPECT_EQ(session->unsaved(), 0u) << session->failure();
}

/// That where their mesh is shown: the garden knows nothing of them.
TEST_F(LabelSessionSavingTest,
       an_edit_of_another_mesh_that_is_stored_without_a_message_is_found_by_asking)
{
  start(std::chrono::seconds(6));
  startGarden();
  session->work(nullptr);
  session->assign("car_1", {5});
  ASSERT_TRUE(untilInGarden([&] { return server->edits().size() == 1; }));
  server->addLabel("car_1", {5});
  ASSERT_TRUE(untilInGarden([&] { return session->unstored() == 0 || session->failed() > 0; }));
  EXPECT_EQ(session->failure(), "");
  EXPECT_EQ(session->display(), garden);
}

TEST_F(LabelSessionSavingTest,
       edits_that_wait_for_one_of_many_faces_are_made_where_their_mesh_is_shown)
{
  start();
  ASSERT_TRUE(showLarge());
  startGarden();
  session->work(nullptr);
  EXPECT_EQ(session->assign("ground_1", allOfLarge()), "");
  EXPECT_EQ(session->takeAway("ground_1", {0}), "");
  EXPECT_EQ(session->assign("wall_7", {3}), "");
  EXPECT_EQ(session->unstored(), 3u);
  ASSERT_TRUE(untilInGarden([&] { return session->display() == garden; }));
  EXPECT_EQ(session->assign("car_2", {5}), "");
  ASSERT_TRUE(untilInGarden([&] { return !garden_server->edits().empty(); }));
  EXPECT_EQ(session->names(), std::vector<std::string>{"car_2"}) << "of the garden";
  garden_server->labels.publish(garden_server->edits()[0].cluster);
  ASSERT_TRUE(untilInGarden([&] {
    const auto edits = server->edits();
    for (; answered < edits.size(); ++answered) {
      server->labels.publish(edits[answered].cluster);
    }
    return session->unstored() == 0;
  })) << session->unstored()
      << " are not stored: " << session->failure();
  EXPECT_EQ(display->labels().at("ground_1")->faces.size(), 124999u);
  EXPECT_EQ(display->labels().at("wall_7")->faces, Faces{3});
  EXPECT_EQ(session->undo(), "undone: labelling 'car_2'");
  session->work(nullptr);
  EXPECT_EQ(session->undo(), "undone: labelling 'wall_7'") << "it is a step of its mesh";
  EXPECT_NE(session->undoOrder(), 0u);
}

TEST_F(LabelSessionSavingTest, one_that_cannot_save_is_not_in_the_way_of_others)
{
  start();
  startGarden();
  storeBoth();
  SaveServer saver(name_space);
  SaveServer garden_saver(name_space + "/garden");
  saver.refusal = "the disk is full";
  EXPECT_EQ(session->save(), "");
  ASSERT_TRUE(until([&] { return !session->isSaving(); }));
  EXPECT_EQ(garden_saver.calls, 1);
  EXPECT_EQ(session->unsaved(), 1u);
  EXPECT_TRUE(session->isUnsaved("car_1"));
  EXPECT_NE(session->failure().find("the disk is full"), std::string::npos) << session->failure();
  saver.refusal.clear();
  EXPECT_EQ(session->save(), "");
  ASSERT_TRUE(until([&] { return !session->isSaving(); }));
  EXPECT_EQ(session->unsaved(), 0u);
  EXPECT_EQ(session->failure(), "");
}

TEST_F(LabelSessionSavingTest, what_was_stored_where_nobody_is_any_more_is_forgotten)
{
  start();
  startGarden();
  storeBoth();
  delete garden;
  SaveServer saver(name_space);
  session->work(nullptr);
  EXPECT_EQ(session->save(), "");
  ASSERT_TRUE(until([&] { return !session->isSaving(); }));
  EXPECT_EQ(saver.calls, 1);
  EXPECT_EQ(session->unsaved(), 0u);
  EXPECT_NE(session->failure().find("nobody offers the service " + name_space +
                                    "/garden/save_map any more"),
            std::string::npos)
      << session->failure();
}
