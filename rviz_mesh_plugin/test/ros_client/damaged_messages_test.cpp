#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mesh_msgs/MeshFaceCluster.h>
#include <mesh_msgs/MeshFaceCostsStamped.h>
#include <mesh_msgs/MeshMaterialsStamped.h>
#include <mesh_msgs/MeshTexture.h>
#include <mesh_msgs/MeshVertexCostsSparseStamped.h>
#include <ros/console.h>
#include <ros/message_deserializer.h>
#include <ros/subscription_queue.h>

#include "ros_client/message_lengths.h"
#include "ros_client/topic_receiver.h"
#include "support/meshes.h"
#include "support/mutations.h"
#include "support/raw_messages.h"

using rviz_mesh_plugin::CheckedCallback;
using rviz_mesh_plugin::findFalseLength;

namespace {

using Bytes = std::vector<std::uint8_t>;

/// One that subscribes to a topic, and the queue that roscpp gives it.
template <class Message>
struct Reader
{
  explicit Reader(const std::string& topic)
      : helper(boost::make_shared<CheckedCallback<Message>>(
            topic,
            [this](const boost::shared_ptr<const Message>& message) {
              received.push_back(raw_messages::bytesOf(*message));
            },
            [this](const std::string& reason) { refused.push_back(reason); })),
        queue(boost::make_shared<ros::SubscriptionQueue>(topic, 10, false))
  {
  }

  std::vector<Bytes> received;  ///< as they would be sent on
  std::vector<std::string> refused;
  ros::SubscriptionCallbackHelperPtr helper;
  boost::shared_ptr<ros::SubscriptionQueue> queue;
};

/// What roscpp does with a message that comes over the network, for two of this process: it is
/// deserialized when the first of them takes it from its queue, and freed.
template <class Message>
class DamagedMessages : public testing::Test
{
 protected:
  void SetUp() override
  {
    // roscpp says each message that it cannot read: thousands here.
    ros::console::set_logger_level("ros.roscpp", ros::console::levels::Fatal);
    ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Fatal);
    ros::console::notifyLoggerLevelsChanged();
  }

  void TearDown() override
  {
    ros::console::set_logger_level("ros.roscpp", ros::console::levels::Info);
    ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Info);
    ros::console::notifyLoggerLevelsChanged();
  }

  /// Bytes come for both.
  void arrive(const Bytes& bytes)
  {
    const boost::shared_array<std::uint8_t> buffer(new std::uint8_t[bytes.size()]);
    std::copy(bytes.begin(), bytes.end(), buffer.get());
    const auto deserializer = boost::make_shared<ros::MessageDeserializer>(
        first.helper, ros::SerializedMessage(buffer, bytes.size()),
        boost::make_shared<ros::M_string>(ros::M_string{{"callerid", "/a_publisher"}}));
    for (Reader<Message>* reader : {&first, &second}) {
      reader->queue->push(reader->helper, deserializer, false, ros::VoidConstWPtr(), false);
    }
  }

  /// Sends bytes to both; each gets the message, or is told once why not.
  void send(const Bytes& bytes)
  {
    for (Reader<Message>* reader : {&first, &second}) {
      reader->received.clear();
      reader->refused.clear();
    }
    arrive(bytes);
    for (Reader<Message>* reader : {&first, &second}) {
      reader->queue->call();
    }
    const std::string reason = findFalseLength<Message>(bytes.data(), bytes.size());
    for (const Reader<Message>* reader : {&first, &second}) {
      ASSERT_EQ(reader->received.size(), reason.empty() ? 1u : 0u);
      ASSERT_EQ(reader->refused,
                reason.empty() ? std::vector<std::string>() : std::vector<std::string>{reason});
    }
    if (reason.empty()) {
      ASSERT_EQ(first.received, second.received);
      // What is beyond the message's end is left out.
      ASSERT_LE(first.received[0].size(), bytes.size());
      ASSERT_EQ(first.received[0],
                Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(first.received[0].size())));
    }
  }

  static Bytes sample();

  Reader<Message> first{"/damaged"};
  Reader<Message> second{"/damaged"};
};

template <>
Bytes DamagedMessages<mesh_msgs::MeshGeometryStamped>::sample()
{
  return raw_messages::bytesOf(test_meshes::square());
}

template <>
Bytes DamagedMessages<mesh_msgs::MeshVertexCostsStamped>::sample()
{
  return raw_messages::bytesOf(test_meshes::costs("slope", {1, 2, 3}));
}

template <>
Bytes DamagedMessages<mesh_msgs::MeshFaceCostsStamped>::sample()
{
  mesh_msgs::MeshFaceCostsStamped message;
  message.uuid = "mesh";
  message.mesh_face_costs.costs = {1, 2};
  return raw_messages::bytesOf(message);
}

template <>
Bytes DamagedMessages<mesh_msgs::MeshVertexCostsSparseStamped>::sample()
{
  mesh_msgs::MeshVertexCostsSparseStamped message;
  message.uuid = "mesh";
  message.mesh_vertex_costs.vertices = {3, 7};
  message.mesh_vertex_costs.costs = {1, 2};
  return raw_messages::bytesOf(message);
}

template <>
Bytes DamagedMessages<mesh_msgs::MeshVertexColorsStamped>::sample()
{
  return raw_messages::bytesOf(test_meshes::colors({test_meshes::color(1, 0, 0)}));
}

template <>
Bytes DamagedMessages<mesh_msgs::MeshMaterialsStamped>::sample()
{
  mesh_msgs::MeshMaterialsStamped message;
  message.uuid = "mesh";
  message.mesh_materials.clusters.resize(1);
  message.mesh_materials.clusters[0].face_indices = {0, 1};
  message.mesh_materials.materials.resize(2);
  message.mesh_materials.cluster_materials = {1};
  message.mesh_materials.vertex_tex_coords.resize(1);
  return raw_messages::bytesOf(message);
}

template <>
Bytes DamagedMessages<mesh_msgs::MeshTexture>::sample()
{
  mesh_msgs::MeshTexture message;
  message.uuid = "mesh";
  message.image.encoding = "rgb8";
  message.image.data = {1, 2, 3};
  return raw_messages::bytesOf(message);
}

template <>
Bytes DamagedMessages<mesh_msgs::MeshFaceCluster>::sample()
{
  mesh_msgs::MeshFaceCluster message;
  message.label = "tree_1";
  message.face_indices = {0, 1, 2};
  return raw_messages::bytesOf(message);
}

using Types =
    testing::Types<mesh_msgs::MeshGeometryStamped, mesh_msgs::MeshVertexCostsStamped,
                   mesh_msgs::MeshFaceCostsStamped, mesh_msgs::MeshVertexCostsSparseStamped,
                   mesh_msgs::MeshVertexColorsStamped, mesh_msgs::MeshMaterialsStamped,
                   mesh_msgs::MeshTexture, mesh_msgs::MeshFaceCluster>;
TYPED_TEST_SUITE(DamagedMessages, Types);

}  // namespace

// roscpp frees the buffer of a message that could not be read; of an empty one it does not see
// that, and reads it again for the next subscriber.
TYPED_TEST(DamagedMessages, of_no_bytes_are_refused_to_each_reader_once)
{
  for (int i = 0; i < 400; ++i) {
    ASSERT_NO_FATAL_FAILURE(this->send({}));
    ASSERT_NE(this->second.refused[0].find("the message is empty"), std::string::npos);
  }
  ASSERT_NO_FATAL_FAILURE(this->send(this->sample()));
  EXPECT_EQ(this->second.received[0], this->sample()) << "the next is read";
}

// Else one that is slow would tell a fast one of an old message as if it were the newest.
TYPED_TEST(DamagedMessages, are_told_to_each_reader_in_its_turn)
{
  for (const Bytes& bytes : {Bytes(), Bytes(3, 0xFF)}) {
    auto& fast = this->first;
    auto& slow = this->second;
    fast.received.clear();
    fast.refused.clear();
    this->arrive(bytes);
    this->arrive(this->sample());
    slow.queue->call();
    EXPECT_EQ(fast.refused.size(), 0u) << "it has not come to that yet";
    fast.queue->call();
    EXPECT_EQ(fast.refused.size(), 1u);
    EXPECT_EQ(fast.received.size(), 0u);
    fast.queue->call();
    slow.queue->call();
    EXPECT_EQ(fast.refused.size(), 1u);
    EXPECT_EQ(fast.received.size(), 1u);
  }
}

TYPED_TEST(DamagedMessages, of_every_short_length_reach_both_readers_or_none)
{
  for (std::size_t length = 0; length <= 64; ++length) {
    for (const std::uint8_t byte : {0x00, 0x01, 0xFF}) {
      ASSERT_NO_FATAL_FAILURE(this->send(Bytes(length, byte))) << length << " of " << int(byte);
    }
  }
}

TYPED_TEST(DamagedMessages, cut_at_each_byte_reach_no_reader)
{
  const Bytes whole = this->sample();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const Bytes part(whole.begin(), whole.begin() + std::ptrdiff_t(length));
    ASSERT_NO_FATAL_FAILURE(this->send(part)) << length << " of " << whole.size();
    ASSERT_EQ(this->first.refused.size(), 1u) << length << " of " << whole.size();
  }
}

TYPED_TEST(DamagedMessages, with_random_bits_flipped_reach_both_readers_or_none)
{
  std::mt19937 random(11);
  const Bytes whole = this->sample();
  for (int i = 0; i < mutations(2000); ++i) {
    Bytes bytes = whole;
    for (std::size_t flips = 1 + random() % 8; flips > 0; --flips) {
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    }
    if (i % 4 == 0) {
      bytes.resize(random() % (2 * bytes.size()));
    }
    ASSERT_NO_FATAL_FAILURE(this->send(bytes)) << "flips " << i;
  }
}

// Otherwise these would get what stands for a damaged message here, and might read them first.
TYPED_TEST(DamagedMessages, are_not_shared_with_subscribers_of_others)
{
  ros::SubscriptionCallbackHelperT<const boost::shared_ptr<const TypeParam>&> other{{}};
  EXPECT_NE(this->first.helper->getTypeInfo(), other.getTypeInfo());
  EXPECT_EQ(this->first.helper->getTypeInfo(), this->second.helper->getTypeInfo());
}
