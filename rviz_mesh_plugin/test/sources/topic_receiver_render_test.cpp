#include <atomic>
#include <chrono>
#include <cstring>
#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <ros/ros.h>

#include "sources/mesh_sources.h"
#include "support/meshes.h"
#include "support/no_threads.h"
#include "support/raw_messages.h"
#include "support/service_servers.h"
#include "threads/work_thread.h"

using rviz_mesh_plugin::MeshMember;
using rviz_mesh_plugin::MeshSources;
using rviz_mesh_plugin::TopicReceiver;
using rviz_mesh_plugin::WorkThread;
using service_servers::Gate;
using service_servers::waitFor;

namespace {

using Message = mesh_msgs::MeshVertexCostsStamped;
using Callbacks = TopicReceiver::Callbacks<Message>;

class Topics : public testing::Test
{
 public:
  /// Counts what is received and keeps what is refused. (roscpp sends what is latched twice where
  /// a subscriber comes while it is being published.)
  Callbacks count(std::atomic<int>& received)
  {
    const auto seen = std::make_shared<std::set<std::uint32_t>>();
    return {[&received, seen](const Message::ConstPtr& message, const TopicReceiver::Flag&) {
              received += seen->insert(message->header.seq).second ? 1 : 0;
            },
            [this](const std::string& reason, const TopicReceiver::Flag&) {
              const std::lock_guard<std::mutex> lock(mutex);
              refusals.push_back(reason);
            }};
  }

  std::vector<std::string> refused()
  {
    const std::lock_guard<std::mutex> lock(mutex);
    return refusals;
  }

  ros::NodeHandle node;
  std::string topic =
      std::string("/topics/") + testing::UnitTest::GetInstance()->current_test_info()->name();
  std::mutex mutex;
  std::vector<std::string> refusals;
};

const Message MESSAGE = test_meshes::costs("slope", {1.0f});

}  // namespace

TEST_F(Topics, are_left_while_a_message_is_being_received)
{
  const auto publisher = node.advertise<Message>(topic, 10, true);
  publisher.publish(MESSAGE);
  Gate gate;
  std::atomic<int> late{0};
  std::atomic<int> received{0};
  auto receiver = std::make_unique<TopicReceiver>();
  Callbacks hanging;
  hanging.receive = [&](const Message::ConstPtr&, const TopicReceiver::Flag& ended) {
    gate.pass();
    late += ended ? 1 : 0;
  };
  auto subscription = receiver->subscribe(node, topic, 10, hanging);
  ASSERT_TRUE(waitFor([&] { return gate.reached == 1; }));
  auto leaving = std::async(std::launch::async, [&] {
    subscription.end();
    subscription = receiver->subscribe(node, topic, 10, count(received));
  });
  EXPECT_EQ(leaving.wait_for(std::chrono::seconds(30)), std::future_status::ready);
  gate.open();
  leaving.wait();
  EXPECT_TRUE(waitFor([&] { return received == 1; })) << "the new one gets what is latched";
  EXPECT_EQ(late, 1) << "the one before is told that nobody wants it";
  publisher.publish(MESSAGE);
  EXPECT_TRUE(waitFor([&] { return received == 2; }));
  EXPECT_EQ(gate.reached, 1);
}

TEST_F(Topics, are_left_for_good_with_their_receiver)
{
  const auto publisher = node.advertise<Message>(topic, 10, true);
  publisher.publish(MESSAGE);
  Gate gate;
  const auto owned = std::make_shared<int>(0);
  {
    TopicReceiver receiver;
    Callbacks hanging;
    hanging.receive = [&gate, owned](const Message::ConstPtr&, const TopicReceiver::Flag&) {
      gate.pass();
    };
    const auto subscription = receiver.subscribe(node, topic, 10, hanging);
    ASSERT_TRUE(waitFor([&] { return gate.reached == 1; }));
  }
  EXPECT_EQ(publisher.getNumSubscribers(), 1u) << "the message is being received still";
  gate.open();
  EXPECT_TRUE(waitFor([&] { return publisher.getNumSubscribers() == 0; }));
  EXPECT_TRUE(waitFor([&] { return owned.use_count() == 1; })) << "all is freed";
}

// roscpp destroys what is in its queue with the queue locked, and locks it to unsubscribe.
TEST_F(Topics, left_while_a_message_is_being_received_let_the_process_end)
{
  const auto publisher = node.advertise<Message>(topic, 10, true);
  publisher.publish(MESSAGE);
  Gate gate;
  Callbacks hanging;
  hanging.receive = [&gate](const Message::ConstPtr&, const TopicReceiver::Flag&) { gate.pass(); };
  TopicReceiver receiver;
  auto subscription = receiver.subscribe(node, topic, 10, hanging);
  ASSERT_TRUE(waitFor([&] { return gate.reached == 1; }));
  std::atomic<bool> running{false}, canceled{false};
  WorkThread last("last");  // to start, and to be canceled
  last.add([&](const rviz_mesh_plugin::Cancellation& cancellation) {
    running = true;
    while (!cancellation.flag()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    canceled = true;
  });
  ASSERT_TRUE(waitFor([&] { return running.load(); }));
  subscription.end();
  const auto joined = std::make_shared<std::promise<void>>();
  std::thread end([joined] {
    WorkThread::joinAll();
    joined->set_value();
  });
  EXPECT_TRUE(waitFor([&] { return canceled.load(); }));
  gate.open();
  const bool has_ended =
      joined->get_future().wait_for(std::chrono::seconds(30)) == std::future_status::ready;
  EXPECT_TRUE(has_ended);
  has_ended ? end.join() : end.detach();
}

// roscpp may lose a subscription that begins while the last one of the topic ends.
TEST_F(Topics, left_and_subscribed_to_again_and_again_are_received)
{
  const auto publisher = node.advertise<Message>(topic, 10, true);
  publisher.publish(MESSAGE);
  std::atomic<int> received{0};
  TopicReceiver receivers[2];
  TopicReceiver::Subscription subscriptions[2];
  for (int i = 0; i < 100; ++i) {
    subscriptions[i % 2].end();
    subscriptions[(i + 1) % 2] = receivers[(i + 1) % 2].subscribe(node, topic, 10, count(received));
    ASSERT_TRUE(waitFor([&] { return received == i + 1; })) << i;
  }
}

TEST_F(Topics, refuse_lengths_that_lie_and_tell_all_who_share_the_message)
{
  std::atomic<int> received{0};
  TopicReceiver receivers[2];
  const auto first = receivers[0].subscribe(node, topic, 10, count(received));
  const auto second = receivers[1].subscribe(node, topic, 10, count(received));
  auto publisher = raw_messages::advertise<Message>(node, topic);
  ASSERT_TRUE(waitFor([&] { return publisher.getNumSubscribers() > 0; }));
  auto bytes = raw_messages::bytesOf(MESSAGE);
  const std::uint32_t huge = 0x20000000;
  std::memcpy(bytes.data() + bytes.size() - 8, &huge, 4);
  publisher.publish(RawBytes{bytes});
  ASSERT_TRUE(waitFor([&] { return refused().size() >= 2; }));
  for (const std::string& reason : refused()) {
    EXPECT_NE(reason.find("an array of 536870912 elements needs 2147483648 bytes"),
              std::string::npos)
        << reason;
  }
  publisher.publish(RawBytes{raw_messages::bytesOf(MESSAGE)});
  ASSERT_TRUE(waitFor([&] { return received == 2; }));
  EXPECT_EQ(refused().size(), 2u);
}

TEST_F(Topics, refuse_what_their_callback_cannot_take)
{
  const auto publisher = node.advertise<Message>(topic, 10, true);
  std::atomic<int> calls{0};
  TopicReceiver receiver;
  Callbacks failing = count(calls);
  failing.receive = [&](const Message::ConstPtr&, const TopicReceiver::Flag&) {
    if (calls++ == 0) {
      throw std::bad_alloc();
    }
  };
  const auto subscription = receiver.subscribe(node, topic, 10, failing);
  publisher.publish(MESSAGE);
  publisher.publish(MESSAGE);
  ASSERT_TRUE(waitFor([&] { return calls == 2; })) << "it goes on";
  ASSERT_EQ(refused().size(), 1u);
  EXPECT_NE(refused()[0].find("the message could not be taken: "), std::string::npos);
}

// They read what comes in roscpp's way, without a look at its lengths first.
TEST_F(Topics, do_not_depend_on_subscribers_of_others)
{
  std::atomic<int> theirs{0};
  const boost::function<void(const Message::ConstPtr&)> count_theirs =
      [&](const Message::ConstPtr&) { ++theirs; };
  const auto other = node.subscribe<Message>(topic, 10, count_theirs);
  std::atomic<int> received{0};
  TopicReceiver receiver;
  const auto subscription = receiver.subscribe(node, topic, 10, count(received));
  auto publisher = raw_messages::advertise<Message>(node, topic);
  ASSERT_TRUE(waitFor([&] { return publisher.getNumSubscribers() > 0; }));
  auto bytes = raw_messages::bytesOf(MESSAGE);
  const std::uint32_t more = 3;
  std::memcpy(bytes.data() + bytes.size() - 8, &more, 4);
  publisher.publish(RawBytes{bytes});
  ASSERT_TRUE(waitFor([&] { return refused().size() == 1; }));
  EXPECT_NE(refused()[0].find("an array of 3 elements needs 12 bytes"), std::string::npos)
      << refused()[0];
  publisher.publish(RawBytes{raw_messages::bytesOf(MESSAGE)});
  ASSERT_TRUE(waitFor([&] {
    ros::spinOnce();
    return received == 1 && theirs == 1;
  }));
}

TEST_F(Topics, say_where_no_thread_can_be_started_and_begin_later)
{
  MeshSources sources(false);
  MeshSources::Names names;
  std::string& name = names.topics[MeshMember::COSTS];
  name = topic;
  {
    const NoThreads none;
    sources.connect(node, names);
    EXPECT_NE(sources.error(MeshMember::COSTS), "");
  }
  name = "not a name";
  sources.connect(node, names);
  EXPECT_NE(sources.error(MeshMember::COSTS), "");
  name = topic;
  sources.connect(node, names);
  EXPECT_EQ(sources.error(MeshMember::COSTS), "");
  const auto publisher = node.advertise<Message>(topic, 10, true);
  publisher.publish(MESSAGE);
  EXPECT_TRUE(
      waitFor([&] { return sources.queue().take().receptions[MeshMember::COSTS].accepted == 1; }));
}
