#include <string>
#include <system_error>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/DeleteLabel.h>
#include <mesh_msgs/SetLabelColor.h>
#include <osmesa_harness/render_fixture.h>

#include "sources/label_client.h"
#include "support/no_threads.h"
#include "support/service_servers.h"

using mesh_msgs::DeleteLabel;
using rviz_mesh_plugin::LabelClient;
using service_servers::Gate;
using service_servers::Servers;

/// An owner of labels, and what is sent to it, in its order.
class LabelClientTest : public osmesa_harness::RenderFixture
{
 protected:
  void SetUp() override
  {
    RenderFixture::SetUp();
    name_space = "/" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name());
    subscriber = node.subscribe<mesh_msgs::MeshFaceClusterStamped>(
        name_space + "/cluster_label", 10,
        [this](const mesh_msgs::MeshFaceClusterStamped::ConstPtr& message) {
          done.push_back("store " + message->cluster.label + " " +
                         std::to_string(message->cluster.face_indices.size()));
        });
    client.connect(node, name_space);
    ASSERT_TRUE(spinUntil([&] { return client.isHeard(); }));
  }

  static rviz_mesh_plugin::SentEdit edit(const std::string& label, std::size_t faces)
  {
    rviz_mesh_plugin::MeshData mesh;
    mesh.uuid = "map";
    return sentEdit(mesh, label, rviz_mesh_plugin::labelFaces(std::vector<std::uint32_t>(faces)),
                    true, nullptr);
  }

  bool comes(std::size_t count)
  {
    return spinUntil([&] {
      const std::string newest = client.work();
      failure = newest.empty() ? failure : newest;
      return done.size() >= count;
    });
  }

  using Done = std::vector<std::string>;
  std::string name_space;
  ros::NodeHandle node;
  ros::Subscriber subscriber;
  LabelClient client;
  Done done;
  std::string failure;
};

TEST_F(LabelClientTest, a_label_is_deleted_by_the_service_and_edits_after_that_wait_for_it)
{
  Servers servers;
  Gate gate;
  const auto service = servers.serve<DeleteLabel>(
      name_space + "/delete_label", [&](DeleteLabel::Request& request, DeleteLabel::Response&) {
        gate.pass();
        done.push_back("delete " + request.label);
        return request.uuid == "map";
      });
  client.store(edit("tree_1", 3));
  ASSERT_TRUE(comes(1));
  client.remove(edit("tree_1", 0));
  client.store(edit("tree_1", 5));  // somebody makes it anew at once
  client.store(edit("car_1", 2));
  ASSERT_TRUE(spinUntil([&] {
    client.work();
    return gate.reached == 1;
  }));
  spinFrames(5);
  client.store(edit("tree_1", 6));  // which replaces what has not gone out
  EXPECT_EQ(done, (Done{"store tree_1 3", "store car_1 2"}))
      << "of the same label, what is stored before it is deleted would be lost; others go on";
  gate.open();
  ASSERT_TRUE(comes(4));
  EXPECT_EQ(done, (Done{"store tree_1 3", "store car_1 2", "delete tree_1", "store tree_1 6"}));
}

TEST_F(LabelClientTest, without_a_thread_what_is_to_be_done_waits_for_one)
{
  Servers servers;
  const auto deleting = servers.serve<DeleteLabel>(
      name_space + "/delete_label", [&](DeleteLabel::Request& request, DeleteLabel::Response&) {
        done.push_back("delete " + request.label);
        return true;
      });
  const auto coloring = servers.serve<mesh_msgs::SetLabelColor>(
      name_space + "/set_label_color",
      [&](mesh_msgs::SetLabelColor::Request& request, mesh_msgs::SetLabelColor::Response&) {
        done.push_back("color " + request.label);
        return true;
      });
  {
    const NoThreads none;
    client.remove(edit("tree_1", 0));
    client.remove(edit("tree_2", 0));
    client.store(edit("tree_1", 4));
    EXPECT_THROW(client.work(), std::system_error);
    EXPECT_THROW(client.work(), std::system_error);
  }
  ASSERT_TRUE(comes(3));
  EXPECT_EQ(done, (Done{"delete tree_1", "delete tree_2", "store tree_1 4"}));
  const rviz_mesh_plugin::Rgba8 red{255, 0, 0, 255};
  {
    const NoThreads none;
    client.setColor("map", "tree_1", &red);
    EXPECT_THROW(client.work(), std::system_error);
  }
  ASSERT_TRUE(comes(4));
  EXPECT_EQ(done.back(), "color tree_1");
}

TEST_F(LabelClientTest, an_owner_that_hangs_does_not_hold_up_later_edits_for_ever)
{
  Servers servers;
  Gate gate;
  const auto service = servers.serve<DeleteLabel>(
      name_space + "/delete_label", [&](DeleteLabel::Request&, DeleteLabel::Response&) {
        gate.pass();
        return true;
      });
  LabelClient hasty(std::chrono::milliseconds(500));
  hasty.connect(node, name_space);
  ASSERT_TRUE(spinUntil([&] { return hasty.isHeard(); }));
  hasty.remove(edit("tree_1", 0));
  ASSERT_TRUE(spinUntil([&] {
    hasty.work();
    return gate.reached == 1;
  }));
  hasty.store(edit("tree_1", 5));
  EXPECT_TRUE(spinUntil([&] {
    const std::string newest = hasty.work();
    failure = newest.empty() ? failure : newest;
    return done.size() == 1;
  }));
  EXPECT_EQ(done, Done{"store tree_1 5"});
  EXPECT_NE(failure.find("has not answered"), std::string::npos) << failure;
  gate.open();
}

TEST_F(LabelClientTest, a_label_that_somebody_else_has_deleted_is_no_failure)
{
  Servers servers;
  const auto service = servers.serve<DeleteLabel>(
      name_space + "/delete_label", [](DeleteLabel::Request&, DeleteLabel::Response&) -> bool {
        throw std::runtime_error("a.h5: there is no label 'tree_1'");
      });
  client.remove(edit("tree_1", 0));
  client.store(edit("tree_1", 2));
  ASSERT_TRUE(comes(1));
  EXPECT_EQ(failure, "");
}

TEST_F(LabelClientTest, where_nobody_deletes_labels_their_faces_are_taken_away)
{
  client.remove(edit("tree_1", 0));
  client.store(edit("car_1", 2));
  ASSERT_TRUE(comes(2));
  EXPECT_EQ(done, (Done{"store car_1 2", "store tree_1 0"}));
  EXPECT_EQ(failure, "");
}

TEST_F(LabelClientTest, a_refusal_is_told)
{
  Servers servers;
  const auto service = servers.serve<DeleteLabel>(
      name_space + "/delete_label", [](DeleteLabel::Request&, DeleteLabel::Response&) -> bool {
        throw std::runtime_error("the disk is full");
      });
  client.remove(edit("tree_1", 0));
  client.store(edit("tree_1", 2));
  ASSERT_TRUE(comes(1));
  EXPECT_NE(failure.find("the label 'tree_1' is not deleted: "), std::string::npos) << failure;
  EXPECT_NE(failure.find("the disk is full"), std::string::npos) << failure;
}
