#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/GetLabelColors.h>
#include <mesh_msgs/MeshLabelColors.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include "sources/label_color_source.h"
#include "support/meshes.h"
#include "support/service_servers.h"

using mesh_msgs::MeshLabelColors;
using rviz_mesh_plugin::LabelColorSource;
using service_servers::waitFor;

namespace {

class ColorFeed : public testing::Test
{
 public:
  ColorFeed() : spinner_(1, &queue_)
  {
    node.setCallbackQueue(&queue_);
    colors = node.advertise<MeshLabelColors>(space + "/label_colors", 100, true);
    spinner_.start();
    sources.connect(node, space);
    EXPECT_TRUE(waitFor([&] { return colors.getNumSubscribers() == 1; }));
  }
  ~ColorFeed() override
  {
    sources.clear();
    colors.shutdown();  // it uses the queue
    spinner_.stop();
  }

  static MeshLabelColors message(const std::string& uuid, float red)
  {
    MeshLabelColors message;
    message.uuid = uuid;
    message.labels = {"tree_1", "tree_2"};
    message.colors = {test_meshes::color(red, 0, 0), test_meshes::color(0, 1, 0)};
    return message;
  }

  bool shows(const std::string& uuid, int red)
  {
    return waitFor([&] {
      const auto known = sources.colors(uuid);
      return known && known->at("tree_1").red == red;
    });
  }

  bool refuses(const MeshLabelColors& message, const std::string& reason)
  {
    colors.publish(message);
    return waitFor([&] {
      const auto status = sources.status();
      return status && status->level == rviz_mesh_plugin::StatusLine::ERROR &&
             status->text.find(reason) != std::string::npos;
    });
  }

  std::string space =
      std::string("/colors/") + testing::UnitTest::GetInstance()->current_test_info()->name();
  ros::NodeHandle node;
  ros::Publisher colors;
  LabelColorSource sources;

 private:
  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_;
};

}  // namespace

TEST_F(ColorFeed, refuses_colors_that_are_none_and_keeps_those_before)
{
  colors.publish(message("mesh", 1.0f));
  ASSERT_TRUE(shows("mesh", 255));
  EXPECT_FALSE(sources.status());
  auto bad = message("mesh", 0.0f);
  bad.colors.pop_back();
  EXPECT_TRUE(refuses(bad, "there are 1 colors for 2 labels"));
  for (const float channel : {NAN, INFINITY, -0.5f, 255.0f}) {
    EXPECT_TRUE(refuses(message("mesh", channel), "the color of label 0, 'tree_1'")) << channel;
  }
  EXPECT_TRUE(shows("mesh", 255));
  colors.publish(message("mesh", 0.2f));
  EXPECT_TRUE(shows("mesh", 51));
  EXPECT_FALSE(sources.status());
}

TEST_F(ColorFeed, keeps_those_of_few_meshes_the_last_that_were_used)
{
  colors.publish(message("shown", 1.0f));
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(shows("shown", 255)) << i;
    colors.publish(message("mesh " + std::to_string(i), 1.0f));
    ASSERT_TRUE(shows("mesh " + std::to_string(i), 255));
  }
  EXPECT_TRUE(sources.colors("mesh 5"));
  EXPECT_FALSE(sources.colors("mesh 4"));
}

TEST_F(ColorFeed, refuses_what_a_service_answers)
{
  service_servers::Servers servers;
  const auto server = servers.serve<mesh_msgs::GetLabelColors>(
      space + "/get_label_colors",
      [](mesh_msgs::GetLabelColors::Request&, mesh_msgs::GetLabelColors::Response& response) {
        response.labels = {"tree_1"};
        return true;
      });
  sources.request("mesh");
  EXPECT_TRUE(waitFor([&] {
    const auto status = sources.status();
    return status &&
           status->text.find("/get_label_colors answers: there are 0 colors for 1 labels") !=
               std::string::npos;
  }));
}
