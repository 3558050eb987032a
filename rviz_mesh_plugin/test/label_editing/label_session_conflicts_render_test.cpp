// Others edit the same labels at the same time, or the mesh changes.
#include <string>
#include <vector>

#include "label_session_fixture.h"

using test_labels::rows;

class LabelSessionConflictsTest : public LabelSessionFixture
{
 protected:
  static Faces with(Faces faces, const Faces& more)
  {
    faces.insert(faces.end(), more.begin(), more.end());
    return faces;
  }
};

TEST_F(LabelSessionConflictsTest, faces_that_others_add_at_the_same_time_stay)
{
  start();
  EXPECT_EQ(session->add("tree_1", {150}), "");
  EXPECT_EQ(session->add("tree_1", {149}), "");
  EXPECT_EQ(*session->faces("tree_1"), with(rows(10, 0, 1), {149, 150}));
  EXPECT_EQ(session->faceCount("tree_1"), 22u);
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  EXPECT_TRUE(received(0, "tree_1", {149, 150}, false));
  ASSERT_TRUE(publish(LabelServer::cluster("tree_1", with(rows(10, 0, 1), {160}))));
  EXPECT_TRUE(session->isUnstored("tree_1"));
  EXPECT_EQ(*session->faces("tree_1"), with(rows(10, 0, 1), {149, 150, 160}));
  ASSERT_TRUE(publish(LabelServer::cluster("tree_1", with(rows(10, 0, 1), {149, 150, 160}))));
  EXPECT_EQ(session->unstored(), 0u) << session->failure();
  EXPECT_TRUE(session->isUnsaved("tree_1"));
}

TEST_F(LabelSessionConflictsTest, adding_to_what_replaces_a_label_replaces_it_by_both)
{
  start();
  EXPECT_EQ(session->assign("tree_1", {7}), "");
  EXPECT_EQ(session->add("tree_1", {5}), "");
  ASSERT_TRUE(store(1));
  EXPECT_TRUE(received(0, "tree_1", {5, 7}));
  EXPECT_EQ(session->unstored(), 0u);
}

TEST_F(LabelSessionConflictsTest, a_label_that_others_have_changed_is_not_renamed_away)
{
  start();
  EXPECT_EQ(session->rename("tree_1", "bush_7"), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  const Faces changed = with(rows(10, 0, 1), {150});
  ASSERT_TRUE(publish(LabelServer::cluster("tree_1", changed)));
  ASSERT_TRUE(store(1));
  ASSERT_TRUE(until([&] { return session->failed() == 1; }));
  EXPECT_NE(session->failure().find("'tree_1' is not stored: it has changed meanwhile"),
            std::string::npos)
      << session->failure();
  EXPECT_EQ(server->edits().size(), 1u);
  session->giveUp();
  EXPECT_EQ(*session->faces("tree_1"), changed);
  EXPECT_EQ(session->remove({"tree_1"}), "");
  ASSERT_TRUE(store(2));
  EXPECT_TRUE(received(1, "tree_1", {}));
}

TEST_F(LabelSessionConflictsTest, a_label_that_others_have_changed_is_not_merged_away)
{
  start();
  EXPECT_EQ(session->merge({"tree_1", "tree_2", "wall_1"}, "tree_2"), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  ASSERT_TRUE(publish(LabelServer::cluster("wall_1", {41})));
  ASSERT_TRUE(store(1));
  ASSERT_TRUE(until([&] { return session->failed() == 1 && server->edits().size() == 2; }));
  EXPECT_TRUE(received(1, "tree_1", {}));
  EXPECT_NE(session->failure().find("'wall_1' is not stored: it has changed meanwhile"),
            std::string::npos)
      << session->failure();
}

TEST_F(LabelSessionConflictsTest, an_edit_on_its_way_is_no_change_by_others)
{
  start();
  EXPECT_EQ(session->add("tree_1", {150}), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  EXPECT_EQ(session->rename("tree_1", "bush_7"), "");
  ASSERT_TRUE(publish(LabelServer::cluster("tree_1", with(rows(10, 0, 1), {150}))));
  ASSERT_TRUE(store(2));
  EXPECT_TRUE(received(1, "bush_7", with(rows(10, 0, 1), {150})));
  ASSERT_TRUE(store(3));
  EXPECT_TRUE(received(2, "tree_1", {}));
  EXPECT_EQ(session->unstored(), 0u) << session->failure();
}

TEST_F(LabelSessionConflictsTest, another_mesh_with_the_same_uuid_has_other_labels)
{
  start();
  EXPECT_EQ(session->remove({"tree_1"}), "");
  ASSERT_TRUE(until([&] { return server->edits().size() == 1; }));
  geometry.publish(test_meshes::square());
  ASSERT_TRUE(until([&] { return session->mesh()->faceCount() == 2; }));
  ASSERT_TRUE(until([&] { return session->labels().count("tree_1") == 0; }));
  session->work(nullptr);
  EXPECT_EQ(session->unstored(), 1u) << "the other mesh has no such label, which says nothing";
  EXPECT_FALSE(session->isUnstored("tree_1"));
  EXPECT_EQ(session->assign("tree_1", {1}), "");
  EXPECT_EQ(session->unstored(), 2u);
  EXPECT_EQ(*session->faces("tree_1"), Faces{1});
}

TEST_F(LabelSessionConflictsTest, labels_are_known_once_those_who_store_them_have_answered)
{
  start();
  EXPECT_TRUE(session->labelsKnown());
  auto garden = test_meshes::square();
  garden.uuid = "garden";  // of which they know nothing
  geometry.publish(garden);
  ASSERT_TRUE(until([&] { return session->mesh()->uuid == "garden"; }));
  EXPECT_FALSE(session->labelsKnown());
  publishMesh();
  EXPECT_TRUE(until([&] { return session->mesh()->uuid == "mesh" && session->labelsKnown(); }));
  set(display, {"Labels Topic"}, "");
  EXPECT_TRUE(until([&] { return session->mesh() && session->labelsKnown(); }))
      << "nobody could be asked";
}
