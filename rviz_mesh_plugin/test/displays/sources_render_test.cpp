#include <chrono>
#include <mutex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/GetGeometry.h>
#include <mesh_msgs/GetVertexColors.h>
#include <mesh_msgs/LayerInfoArray.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>
#include <std_msgs/String.h>

#include "ros_client/topic_directory.h"
#include "support/display_fixture.h"

/// Topics and services of a mesh display that change while it has data.
class SourcesTest : public DisplayFixture
{
 protected:
  /// A square of this name.
  ros::ServiceServer serveGeometry(const std::string& name, const std::string& uuid)
  {
    using Service = mesh_msgs::GetGeometry;
    const boost::function<bool(Service::Request&, Service::Response&)> callback =
        [uuid](Service::Request&, Service::Response& response) {
          response.mesh_geometry_stamped = test_meshes::square();
          response.mesh_geometry_stamped.uuid = uuid;
          return true;
        };
    servers.setCallbackQueue(&queue);
    return servers.advertiseService(name, callback);
  }

  template <class Server>
  ros::ServiceServer serveColors(const std::string& name, const Server& answer)
  {
    using Service = mesh_msgs::GetVertexColors;
    const boost::function<bool(Service::Request&, Service::Response&)> callback =
        [answer](Service::Request& request, Service::Response& response) {
          response.mesh_vertex_colors_stamped = answer(request.uuid);
          return true;
        };
    servers.setCallbackQueue(&queue);
    return servers.advertiseService(name, callback);
  }

  ros::CallbackQueue queue;
  ros::NodeHandle servers;
};

TEST_F(SourcesTest, another_topic_of_costs_leaves_those_of_the_others)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  ASSERT_TRUE(show(display, test_meshes::square()));
  costs.publish(test_meshes::costs("a", {1, 2, 3, 4}));
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 4 costs from 1 to 4"));
  set(display, {"Display Type", "Face Costs Topic"}, (costs_topic + "/faces").c_str());
  set(display, {"Display Type", "Update Topic"}, (costs_topic + "/changes").c_str());
  spin(300);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 4 costs from 1 to 4"));
  set(display, {"Display Type", "Vertex Costs Topic"}, (costs_topic + "_of_another").c_str());
  EXPECT_TRUE(waitForStatus(display, "Costs", "Warn", "no costs received")) << "that was its own";
}

TEST_F(SourcesTest, what_the_map_remarks_beside_its_mesh_is_said)
{
  auto* display = createMeshDisplay();
  auto remark = node.advertise<std_msgs::String>(
      ros::names::parentNamespace(geometry_topic) + "/remark", 1, true);
  ASSERT_TRUE(show(display, test_meshes::square()));
  EXPECT_EQ(status(display, "Map"), "");
  std_msgs::String message;
  message.data = "edges are longer\nthan the robot's radius";
  remark.publish(message);
  EXPECT_TRUE(waitForStatus(display, "Map", "Warn", "edges are longer than the robot's radius"));
  message.data = "";
  remark.publish(message);
  EXPECT_TRUE(spinUntil([&] { return status(display, "Map").empty(); }));
  message.data = "again";
  remark.publish(message);
  EXPECT_TRUE(waitForStatus(display, "Map", "Warn", "again"));
  set(display, {"Geometry Topic"}, "/of_another/mesh");
  EXPECT_TRUE(spinUntil([&] { return status(display, "Map").empty(); })) << "of another map";
}

TEST_F(SourcesTest, what_costs_mean_is_heard_beside_the_mesh_and_said_in_the_status)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "slope");
  auto info = node.advertise<mesh_msgs::LayerInfoArray>(
      ros::names::parentNamespace(geometry_topic) + "/layer_info", 1, true);
  mesh_msgs::LayerInfoArray message;
  message.uuid = test_meshes::square().uuid;
  message.layers.resize(1);
  message.layers[0].name = "slope";
  message.layers[0].unit = "rad";
  message.layers[0].comparison = mesh_msgs::LayerInfo::ABOVE;
  message.layers[0].threshold = 2.5f;
  message.layers[0].lethal = 2;
  info.publish(message);
  ASSERT_TRUE(show(display, test_meshes::square()));
  costs.publish(test_meshes::costs("slope", {1, 2, 3, 4}));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "2 lethal (lethal above 2.5 rad), 0 unknown"));
  message.layers[0].comparison = mesh_msgs::LayerInfo::OTHER;
  info.publish(message);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "2 lethal by a rule of the layer's own"));
  message.layers[0].comparison = mesh_msgs::LayerInfo::NONE;
  message.layers[0].infinity = "not reached";
  info.publish(message);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "0 not reached, 0 unknown"));
  message.uuid = "of another mesh";
  info.publish(message);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "0 lethal, 0 unknown"));
}

TEST_F(SourcesTest, the_limits_in_the_status_are_those_that_are_drawn)
{
  auto* display = createMeshDisplay();
  set(display, {"Buffer Size"}, 2);
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  auto other = test_meshes::square();
  other.uuid = "other";
  ASSERT_TRUE(show(display, other));
  ASSERT_TRUE(show(display, test_meshes::square()));
  costs.publish(test_meshes::costs("a", {1, 2, 3, 4}));
  costs.publish(test_meshes::costs("a", {5, 6, 7, 8}, "other"));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "costs from 1 to 4"));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "colors from 1 to 8"));
}

TEST_F(SourcesTest, every_mesh_that_is_shown_gets_its_colors_from_the_service)
{
  std::mutex mutex;
  std::vector<std::string> asked;
  const auto answer = [&](const std::string& uuid) {
    const std::lock_guard<std::mutex> lock(mutex);
    asked.push_back(uuid);
    return test_meshes::colors(std::vector<std_msgs::ColorRGBA>(4, test_meshes::color(0, 0, 1)),
                               uuid);
  };
  const auto server = serveColors(geometry_topic + "_colors", answer);
  const auto other_server = serveColors(geometry_topic + "_other_colors", answer);
  ros::AsyncSpinner spinner(1, &queue);
  spinner.start();
  auto* display = createMeshDisplay();
  set(display, {"Buffer Size"}, 2);
  set(display, {"Display Type", "Vertex Colors Topic"}, "");
  auto other = test_meshes::square();
  other.uuid = "other";
  ASSERT_TRUE(show(display, other));
  ASSERT_TRUE(show(display, test_meshes::square()));
  const auto count = [&] {
    const std::lock_guard<std::mutex> lock(mutex);
    return asked.size();
  };
  set(display, {"Display Type", "Vertex Color Service Name"}, (geometry_topic + "_colors").c_str());
  set(display, {"Display Type"}, "Vertex Color");
  EXPECT_TRUE(spinUntil([&] { return count() == 2; })) << status(display, "Services");
  EXPECT_TRUE(waitForStatus(display, "Colors", "Ok", "4 colors"));
  // Another service is another origin.
  set(display, {"Display Type", "Vertex Color Service Name"},
      (geometry_topic + "_other_colors").c_str());
  EXPECT_TRUE(spinUntil([&] { return count() == 4; })) << status(display, "Services");
  EXPECT_TRUE(waitForStatus(display, "Colors", "Ok", "4 colors"));
  spin(300);
  EXPECT_EQ(count(), 4u);
  delete display;
  spinner.stop();
}

TEST_F(SourcesTest, a_silent_topic_is_not_taken_for_the_map_of_another_robot)
{
  const std::string robots = ros::names::parentNamespace(geometry_topic);
  const auto of_robot_1 = serveGeometry(robots + "/get_geometry", "robot 1");
  const auto global = serveGeometry("/get_geometry", "global");
  ros::AsyncSpinner spinner(1, &queue);
  spinner.start();
  auto* display = createMeshDisplay();
  set(display, {"Geometry Topic"}, (robots + "/robot_2/mesh/geometry").c_str());
  EXPECT_TRUE(waitForStatus(display, "Services", "Ok",
                            "there is no " + robots + "/robot_2/mesh/get_geometry and " + robots +
                                "/robot_2/get_geometry;"));
  EXPECT_FALSE(display->mesh());
  EXPECT_TRUE(waitForStatus(display, "Topic", "Warn", "no message received"));
  const auto of_robot_2 = serveGeometry(robots + "/robot_2/get_geometry", "robot 2");
  ASSERT_TRUE(spinUntil([&] { return display->mesh() != nullptr; })) << status(display, "Services");
  EXPECT_EQ(display->mesh()->uuid, "robot 2");
  EXPECT_TRUE(waitForStatus(display, "Topic", "Ok",
                            "no message received on " + robots +
                                "/robot_2/mesh/geometry yet; the service " + robots +
                                "/robot_2/get_geometry has brought the mesh"));
  delete display;
  spinner.stop();
}

TEST_F(SourcesTest, what_came_by_service_is_not_counted_as_messages)
{
  const auto of_map = serveGeometry(geometry_topic + "_map/get_geometry", "mesh");
  const auto colors_of_map =
      serveColors(geometry_topic + "_map/get_vertex_colors", [](const std::string& uuid) {
        return test_meshes::colors({test_meshes::color(0, 0, 7)}, uuid);
      });
  ros::AsyncSpinner spinner(1, &queue);
  spinner.start();
  auto* display = createMeshDisplay();
  set(display, {"Geometry Topic"}, (geometry_topic + "_map/mesh").c_str());
  ASSERT_TRUE(spinUntil([&] { return display->mesh() != nullptr; })) << status(display, "Services");
  set(display, {"Display Type"}, "Vertex Color");
  EXPECT_TRUE(waitForStatus(display, "Colors", "Error",
                            "answer of the service " + geometry_topic +
                                "_map/get_vertex_colors ignored: the color of vertex 0"));
  auto late = node.advertise<mesh_msgs::MeshGeometryStamped>(geometry_topic + "_map/mesh", 1, true);
  late.publish(test_meshes::square());
  EXPECT_TRUE(waitForStatus(display, "Topic", "Ok", "1 message received; before, the service"));
  auto broken = test_meshes::square();
  broken.mesh_geometry.faces[0].vertex_indices[0] = 9;
  late.publish(broken);
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Error", "message ignored: face 0"));
  EXPECT_TRUE(
      waitForStatus(display, "Topic", "Ok", "2 messages received; 1 of 2 messages refused"));
  delete display;
  spinner.stop();
}

TEST_F(SourcesTest, a_topic_of_another_type_is_named_in_the_line_of_its_concern)
{
  const std::string topic = geometry_topic + "_of_others";
  const ros::Publisher others = node.advertise<std_msgs::String>(topic, 1);
  auto* display = createMeshDisplay();
  const auto sentence = [&](const std::string& type) {
    return "Error: Topic " + topic + " has type std_msgs/String, expected mesh_msgs/" + type +
           ": choose another topic";
  };
  struct Case
  {
    std::vector<const char*> property;
    const char* line;
    const char* type;
  };
  // One after the other: roscpp subscribes to a topic with one type only.
  const Case cases[] = {
      {{"Geometry Topic"}, "Topic", "MeshGeometryStamped"},
      {{"Display Type", "Vertex Costs Topic"}, "Costs", "MeshVertexCostsStamped"},
      {{"Display Type", "Face Costs Topic"}, "Costs", "MeshFaceCostsStamped"},
      {{"Display Type", "Update Topic"}, "Costs", "MeshVertexCostsSparseStamped"},
      {{"Display Type", "Vertex Colors Topic"}, "Colors", "MeshVertexColorsStamped"},
      {{"Display Type", "Materials Topic"}, "Textures", "MeshMaterialsStamped"},
      {{"Display Type", "Textures Topic"}, "Textures", "MeshTexture"},
      {{"Show Labels", "Labels Topic"}, "Labels", "MeshFaceCluster"},
  };
  for (const Case& one : cases) {
    const QVariant before = find(display, one.property)->getValue();
    set(display, one.property, topic.c_str());
    EXPECT_TRUE(spinUntil([&] { return status(display, one.line) == sentence(one.type); }))
        << one.type << ": " << status(display, one.line);
    set(display, one.property, before);
    EXPECT_TRUE(spinUntil([&] {
      return status(display, one.line).find(topic) == std::string::npos;
    })) << status(display, one.line);
  }
  EXPECT_TRUE(show(display, test_meshes::square())) << "on the topic that it had before";
}

TEST_F(SourcesTest, the_master_is_asked_about_silent_topics_only_and_not_too_often)
{
  using rviz_mesh_plugin::TopicDirectory;
  using namespace std::chrono_literals;
  const std::string topic = geometry_topic + "_of_others";
  auto others = node.advertise<std_msgs::String>(topic, 1);
  TopicDirectory topics;
  const TopicDirectory::Clock::time_point start;
  topics.update(start, {});
  topics.update(start + TopicDirectory::PATIENCE, {topic});
  topics.update(start + 2 * TopicDirectory::PATIENCE - 1ms, {topic});
  EXPECT_FALSE(topics.asking()) << "something may come yet";
  TopicDirectory::Clock::time_point now = start + 2 * TopicDirectory::PATIENCE;
  topics.update(now, {topic});
  ASSERT_TRUE(spinUntil([&] { return !topics.asking(); }));
  EXPECT_EQ(topics.problem(topic, "a/B"), "") << "not taken yet";
  topics.update(now, {topic});
  EXPECT_FALSE(topics.asking()) << "not at once again";
  EXPECT_EQ(topics.problem(topic, "a/B"),
            "Topic " + topic + " has type std_msgs/String, expected a/B: choose another topic");
  EXPECT_EQ(topics.problem(topic, "std_msgs/String"), "");
  EXPECT_EQ(topics.problem(geometry_topic, "a/B"), "") << "not said to be silent";
  others.shutdown();
  now += TopicDirectory::INTERVAL;
  topics.update(now - 1ms, {topic});
  EXPECT_FALSE(topics.asking());
  topics.update(now, {topic});
  const auto known = [&] {
    topics.update(now, {topic});
    return topics.problem(topic, "a/B").empty();
  };
  EXPECT_TRUE(spinUntil(known)) << "nobody publishes it any more";
  topics.update(now + 2 * TopicDirectory::INTERVAL, {});
  EXPECT_FALSE(topics.asking()) << "nothing is silent";
}
