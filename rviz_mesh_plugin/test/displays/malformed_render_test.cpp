#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <ros/console.h>
#include <unistd.h>

#include "support/display_fixture.h"
#include "support/mutations.h"
#include "support/raw_messages.h"

namespace {

mesh_msgs::MeshGeometryStamped grid(std::uint32_t cells)
{
  auto message = test_meshes::terrain(cells, [](double x, double y) { return 0.1 * x * y; });
  message.mesh_geometry.vertex_normals.resize(message.mesh_geometry.vertices.size());
  for (auto& normal : message.mesh_geometry.vertex_normals) {
    normal.z = 1.0;
  }
  return message;
}

/// A publisher in another process: what it sends comes over the network.
class OtherProcess
{
 public:
  OtherProcess(const std::string& topic, const std::string& type)
      : pipe_(::popen(("/usr/bin/python3 '" PUBLISH_BYTES "' " + topic + " " + type +
                       " publish_bytes_" + std::to_string(::getpid()))
                          .c_str(),
                      "w"))
  {
  }
  ~OtherProcess()
  {
    if (pipe_) {
      ::pclose(pipe_);
    }
  }
  OtherProcess(const OtherProcess&) = delete;
  OtherProcess& operator=(const OtherProcess&) = delete;

  void publish(const std::vector<std::uint8_t>& bytes) const
  {
    ASSERT_NE(pipe_, nullptr);
    for (const std::uint8_t byte : bytes) {
      std::fprintf(pipe_, "%02x", byte);
    }
    std::fputc('\n', pipe_);
    ASSERT_EQ(std::fflush(pipe_), 0);
  }

 private:
  std::FILE* pipe_;
};

/// Damages a message: bytes, the end, words that numbers rarely have.
class Mutator
{
 public:
  std::vector<std::uint8_t> operator()(std::vector<std::uint8_t> bytes)
  {
    switch (below(4)) {
      case 0:
        bytes.resize(below(bytes.size() + 1));
        break;
      case 1:
        bytes.resize(bytes.size() + below(64) + 1, 0xFF);
        break;
      case 2:
        for (std::size_t i = 1 + below(20); i > 0 && !bytes.empty(); --i) {
          bytes[below(bytes.size())] = static_cast<std::uint8_t>(below(256));
        }
        break;
      default: {
        static const std::vector<std::vector<std::uint8_t>> words{
            {0xFF, 0xFF, 0xFF, 0xFF},       {0x00, 0x00, 0x00, 0x80},
            {0xFF, 0xFF, 0xFF, 0x7F},       {0x00, 0x00, 0xC0, 0x7F},
            {0x00, 0x00, 0x80, 0xFF},       {0, 0, 0, 0, 0, 0, 0xF8, 0x7F},
            {0, 0, 0, 0, 0, 0, 0xF0, 0x7F}, {0x3C, 0xE4, 0x37, 0x7E, 0x9C, 0x75, 0x00, 0x7F}};
        const auto& word = words[below(words.size())];
        if (bytes.size() > word.size()) {
          const std::size_t at = below((bytes.size() - word.size()) / 4) * 4;
          std::copy(word.begin(), word.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
        }
      }
    }
    return bytes;
  }

 private:
  std::size_t below(std::size_t limit)
  {
    return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_);
  }

  std::mt19937 random_{7};
};

}  // namespace

class MalformedTest : public DisplayFixture
{
 protected:
  void SetUp() override
  {
    DisplayFixture::SetUp();
    // RViz says each message that it cannot read: hundreds here.
    ros::console::set_logger_level("ros.roscpp", ros::console::levels::Fatal);
    ros::console::notifyLoggerLevelsChanged();
  }

  void TearDown() override
  {
    ros::console::set_logger_level("ros.roscpp", ros::console::levels::Info);
    ros::console::notifyLoggerLevelsChanged();
    DisplayFixture::TearDown();
  }

  /// @param typed what publishes on the topic; roscpp would number its headers in the raw messages
  template <class Message>
  void bombard(const std::string& topic, ros::Publisher& typed, const Message& message)
  {
    typed.shutdown();
    ros::Publisher raw = raw_messages::advertise<Message>(node, topic);
    ASSERT_TRUE(spinUntil([&raw] { return raw.getNumSubscribers() > 0; })) << topic;
    const auto bytes = raw_messages::bytesOf(message);
    std::vector<std::uint8_t> all_ones(4096, 0xFF);
    Mutator mutate;
    for (int i = 0; i <= mutations(400); ++i) {
      raw.publish(RawBytes{i == 0 ? all_ones : mutate(bytes)});
      spin(2);
    }
    raw.publish(RawBytes{bytes});  // it is the format of the topic, after all
    spin(50);
    raw.shutdown();
    typed = node.advertise<Message>(topic, 100, true);
  }
};

// roscpp would make room for 13 GB, and fill it.
TEST_F(MalformedTest, a_message_that_lies_about_its_length_is_refused)
{
  auto* first = createMeshDisplay();
  auto* second = createMeshDisplay();
  geometry.shutdown();
  auto raw = raw_messages::advertise<mesh_msgs::MeshGeometryStamped>(node, geometry_topic);
  ASSERT_TRUE(spinUntil([&raw] { return raw.getNumSubscribers() > 0; }));
  auto message = grid(2);
  auto bytes = raw_messages::bytesOf(message);
  const std::size_t vertices = 12 + 4 + 3 + 4 + 4;  // after header and uuid
  const std::uint32_t huge = 0x20000000;
  std::memcpy(bytes.data() + vertices, &huge, sizeof(huge));
  raw.publish(RawBytes{bytes});
  for (auto* display : {first, second}) {
    EXPECT_TRUE(waitForStatus(display, "Geometry", "Error",
                              "an array of 536870912 geometry_msgs/Point needs 12884901888 bytes"));
  }
  raw.publish(RawBytes{raw_messages::bytesOf(message)});
  for (auto* display : {first, second}) {
    EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "9 vertices, 8 faces"));
    EXPECT_TRUE(waitForStatus(display, "Topic", "Ok",
                              "1 of 2 messages refused, the last one: an array of 536870912"));
  }
}

TEST_F(MalformedTest, empty_messages_are_told_to_all_who_share_the_topic)
{
  auto* first = createMeshDisplay();
  auto* second = createMeshDisplay();
  geometry.shutdown();
  const OtherProcess publisher(geometry_topic, "mesh_msgs/MeshGeometryStamped");
  for (int i = 0; i < 400; ++i) {
    publisher.publish({});
  }
  for (auto* display : {first, second}) {
    EXPECT_TRUE(
        waitForStatus(display, "Geometry", "Error", "message ignored: the message is empty"));
  }
  publisher.publish(raw_messages::bytesOf(grid(2)));
  for (auto* display : {first, second}) {
    EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "9 vertices, 8 faces"));
    EXPECT_TRUE(
        waitForStatus(display, "Topic", "Ok", "refused, the last one: the message is empty"));
  }
}

TEST_F(MalformedTest, damaged_bytes_from_another_process_reach_both_of_two_displays_or_none)
{
  auto* first = createMeshDisplay();
  auto* second = createMeshDisplay();
  geometry.shutdown();
  const OtherProcess publisher(geometry_topic, "mesh_msgs/MeshGeometryStamped");
  const auto bytes = raw_messages::bytesOf(grid(2));
  Mutator mutate;
  for (int i = 0; i < mutations(2000); ++i) {
    publisher.publish(i % 10 == 0 ? std::vector<std::uint8_t>() : mutate(bytes));
    if (i % 100 == 99) {
      spin(2);
    }
  }
  publisher.publish(raw_messages::bytesOf(grid(3)));
  for (auto* display : {first, second}) {
    EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "16 vertices, 18 faces"));
    EXPECT_TRUE(waitForStatus(display, "Topic", "Ok", "refused"));
  }
}

TEST_F(MalformedTest, damaged_bytes_of_a_geometry_do_no_harm)
{
  auto* display = createMeshDisplay();
  bombard(geometry_topic, geometry, grid(3));
  geometry.publish(grid(4));
  EXPECT_TRUE(waitForStatus(display, "Geometry", "Ok", "25 vertices, 32 faces"));
  EXPECT_TRUE(waitForStatus(display, "Topic", "Ok", "refused"));
}

TEST_F(MalformedTest, damaged_bytes_of_costs_and_colors_do_no_harm)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  ASSERT_TRUE(show(display, grid(4)));
  const auto layer = test_meshes::costs("a", std::vector<float>(25, 1.0f));
  bombard(costs_topic, costs, layer);
  const std::vector<std_msgs::ColorRGBA> red(25, test_meshes::color(1, 0, 0));
  bombard(colors_topic, colors, test_meshes::colors(red));
  spinFrames();
  auto better = layer;
  std::fill(better.mesh_vertex_costs.costs.begin(), better.mesh_vertex_costs.costs.end(), 2.0f);
  costs.publish(better);
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 25 costs from 2 to 2"));
  set(display, {"Display Type"}, "Vertex Color");
  colors.publish(test_meshes::colors(red));
  EXPECT_TRUE(waitForStatus(display, "Colors", "Ok", "25 colors"));
}

TEST_F(MalformedTest, damaged_bytes_of_updates_do_no_harm)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "a");
  ASSERT_TRUE(show(display, grid(4)));
  costs.publish(test_meshes::costs("a", std::vector<float>(25, 1.0f)));
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'"));
  mesh_msgs::MeshVertexCostsSparseStamped update;
  update.header.frame_id = "map";
  update.uuid = "mesh";
  update.type = "a";
  update.mesh_vertex_costs.vertices = {3, 7};
  update.mesh_vertex_costs.costs = {3.0f, 4.0f};
  ros::Publisher updates;
  bombard(costs_topic + "/updates", updates, update);
  costs.publish(test_meshes::costs("a", std::vector<float>(25, 2.0f)));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'a': 25 costs from 2 to 2"));
}
