#include "ros_client/topic_directory.h"

#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <ros/init.h>
#include <sys/socket.h>
#include <unistd.h>

using rviz_mesh_plugin::TopicDirectory;

namespace {

/// A ROS master that takes a question, and whose answer never comes to an end.
class EndlessMaster
{
 public:
  EndlessMaster() : socket_(::socket(AF_INET, SOCK_STREAM, 0))
  {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (::bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        ::listen(socket_, 1) != 0 ||
        ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      std::abort();
    }
    port_ = ntohs(address.sin_port);
    std::thread([this] { answer(); }).detach();
  }

  std::string uri() const { return "http://127.0.0.1:" + std::to_string(port_); }
  bool asked() const { return asked_; }

 private:
  void answer()
  {
    const int connection = ::accept(socket_, nullptr, nullptr);
    char question[16];
    asked_ = ::recv(connection, question, sizeof(question), 0) > 0;
    while (::send(connection, " ", 1, MSG_NOSIGNAL) == 1) {
      ::usleep(100000);
    }
  }

  int socket_;
  int port_ = 0;
  std::atomic<bool> asked_{false};
};

/// Adds a display by its topic, and closes RViz while the master is asked.
[[noreturn]] void close()
{
  ::alarm(60);                  // seconds; where it waits for the master, it waits forever
  static EndlessMaster master;  // its thread needs it to the very end
  ros::init(ros::M_string{{"__master", master.uri()}}, "topic_directory_test",
            ros::init_options::NoSigintHandler);
  {
    TopicDirectory topics;
    topics.propose("/map/mesh");
    while (!master.asked()) {
      ::usleep(1000);
    }
    if (topics.takeProposal()) {
      std::abort();
    }
    topics.propose("/map/other");  // what was asked before is given up
  }
  std::exit(0);
}

}  // namespace

TEST(TopicDirectory, is_given_up_when_rviz_is_closed_while_the_master_hangs)
{
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(close(), testing::ExitedWithCode(0), "");
}
