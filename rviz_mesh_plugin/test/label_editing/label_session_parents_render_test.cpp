#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <mesh_msgs/GetDerivedMesh.h>

#include "label_session_fixture.h"
#include "support/service_servers.h"

using test_labels::rows;

/// The mesh of 200 faces was made of one of 50: four parts each.
class LabelsOfAParentTest : public LabelSessionFixture
{
 protected:
  void tell(std::size_t faces)
  {
    service = servers.serve<mesh_msgs::GetDerivedMesh>(
        name_space + "/get_derived_mesh", [this, faces](auto& request, auto& response) {
          ++asked;
          for (std::uint32_t face = 0; face < faces; ++face) {
            response.face_parents.push_back(face / 4);
          }
          response.parent_uuid = "parent";
          return knows && request.uuid == "mesh";
        });
  }

  void TearDown() override
  {
    service.shutdown();
    LabelSessionFixture::TearDown();
  }

  service_servers::Servers servers;
  ros::ServiceServer service;
  std::atomic<int> asked{0};
  std::atomic<bool> knows{true};
};

TEST_F(LabelsOfAParentTest, are_of_whole_faces_of_it)
{
  tell(200);
  start();
  ASSERT_TRUE(until([&] { return display->faceParents() != nullptr; }));
  EXPECT_EQ(session->assign("car_1", {5, 198}), "");
  ASSERT_TRUE(store(1));
  EXPECT_TRUE(received(0, "car_1", {4, 5, 6, 7, 196, 197, 198, 199}));
  EXPECT_FALSE(session->isUnstored("car_1")) << "it has come back with all parts";
  EXPECT_EQ(session->add("car_1", {8}), "");
  ASSERT_TRUE(store(2));
  EXPECT_TRUE(received(1, "car_1", {8, 9, 10, 11}, false));
  EXPECT_EQ(session->takeAway("car_1", {197, 9}), "");
  ASSERT_TRUE(store(3));
  EXPECT_TRUE(received(2, "car_1", {4, 5, 6, 7}));
  EXPECT_EQ(session->unstored(), 0u);
  EXPECT_EQ(asked, 1);
}

TEST_F(LabelsOfAParentTest, are_of_single_faces_where_that_is_of_another_mesh)
{
  tell(199);
  start();
  ASSERT_TRUE(until([&] { return asked > 0; }));
  EXPECT_EQ(session->assign("car_1", {5}), "");
  ASSERT_TRUE(store(1));
  EXPECT_TRUE(received(0, "car_1", {5}));
  EXPECT_EQ(display->faceParents(), nullptr);
}

TEST_F(LabelsOfAParentTest, are_asked_for_again_with_an_edit_after_a_refusal)
{
  knows = false;
  tell(200);
  start();
  ASSERT_TRUE(until([&] { return asked > 0; }));
  EXPECT_EQ(display->faceParents(), nullptr);
  knows = true;
  ASSERT_TRUE(until([&] {
    session->assign("car_1", {5});
    return display->faceParents() != nullptr;
  }));
  EXPECT_EQ(session->assign("car_2", {10}), "");
  ASSERT_TRUE(until([&] {
    const auto edits = server->edits();
    return !edits.empty() && edits.back().cluster.label == "car_2";
  }));
  ASSERT_TRUE(publish(LabelServer::cluster("car_2", {8, 9, 10, 11})));
  EXPECT_FALSE(session->isUnstored("car_2"));
}

TEST_F(LabelsOfAParentTest, are_known_when_the_edit_is_sent_again)
{
  start(std::chrono::milliseconds(0));  // what is sent has failed in the next frame
  EXPECT_EQ(session->assign("car_1", {5}), "");
  ASSERT_TRUE(until([&] { return session->failed() == 1; }));
  tell(200);
  ASSERT_TRUE(until([&] {
    if (session->failed() == 1) {
      session->sendAgain();
    }
    return display->faceParents() != nullptr;
  }));
  session->sendAgain();
  ASSERT_TRUE(until([&] {
    const auto edits = server->edits();
    return !edits.empty() && edits.back().cluster.face_indices == Faces{4, 5, 6, 7};
  }));
  ASSERT_TRUE(publish(LabelServer::cluster("car_1", {4, 5, 6, 7})));
  EXPECT_EQ(session->unstored(), 0u);
}
