#include "navigation/server_connection.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <iterator>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include <actionlib_msgs/GoalID.h>
#include <ros/console.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "base/status_lines.h"
#include "navigation/diagnostic_array.h"
#include "ros_client/topic_receiver.h"
#include "threads/work_thread.h"

namespace rviz_mesh_plugin {
namespace {

using Time = ServerWatch::Time;
using Flag = TopicReceiver::Flag;

constexpr std::uint32_t QUEUE = 20;
constexpr std::size_t MOST_EVENTS = 5000;  // of minutes in which nobody looked

/// Of all connections: it registers and unregisters at the ROS master.
WorkThread& masterThread()
{
  static auto* const thread = new WorkThread("ROS navigation", NAME_PATIENCE);
  return *thread;
}

/// Of the server itself, in its node's entry.
std::optional<DiagnosticStatus> ownStatus(const DiagnosticArray& message, const std::string& server)
{
  const std::string name = server.substr(server.find_first_not_of('/')) + ": navigation";
  const auto found = std::find_if(
      message.status.begin(), message.status.end(),
      [&](const auto& status) { return status.name == name || status.name == "/" + name; });
  return found == message.status.end() ? std::nullopt : std::make_optional(*found);
}

/// Others than ours do not say so.
bool isReady(const DiagnosticStatus& status)
{
  constexpr std::int8_t ERROR = 2;
  for (const DiagnosticValue& value : status.values) {
    if (value.key == "ready") {
      return value.value == "True" || value.value == "true";
    }
  }
  return status.level < ERROR;
}

/// What is done with the messages of a topic.
template <class M>
struct Take
{
  using Message = M;
  void operator()(ServerWatch& watch, const Message& message, Time /*now*/) const
  {
    watch.take(message);
  }
};
template <class M>
struct TakeWithTime
{
  using Message = M;
  void operator()(ServerWatch& watch, const Message& message, Time now) const
  {
    watch.take(message, now);
  }
};
struct TakeStatus
{
  using Message = actionlib_msgs::GoalStatusArray;
  NavigationAction action;
  void operator()(ServerWatch& watch, const Message& message, Time now) const
  {
    watch.takeStatus(action, message, now);
  }
};

}  // namespace

/// Written by the receiver's thread, and read by the GUI thread.
struct ServerConnection::Events
{
  using Event = std::function<void(ServerWatch&)>;

  std::mutex mutex;
  std::deque<Event> waiting;

  void add(Event event)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    if (waiting.size() == MOST_EVENTS) {
      waiting.pop_front();
    }
    waiting.push_back(std::move(event));
  }
};

/// What has to be registered.
struct ServerConnection::Link
{
  TopicReceiver receiver;
  std::vector<TopicReceiver::Subscription> subscriptions;
  ros::Publisher cancel[ACTION_COUNT];
  ros::Publisher choice;
};

struct ServerConnection::Shared
{
  const std::shared_ptr<Events> events = std::make_shared<Events>();

  std::mutex mutex;
  std::shared_ptr<Link> link;  ///< null: not yet, or no more
  bool ended = false;
  std::optional<mbf_msgs::MoveBaseGoal> choice;  ///< to be told

  std::shared_ptr<Link> now()
  {
    const std::lock_guard<std::mutex> lock(mutex);
    return link;
  }
};

ServerConnection::ServerConnection(const std::string& server) : shared_(std::make_shared<Shared>())
{
  masterThread().add([server, shared = shared_](const Cancellation&) {
    try {
      connect(server, *shared);
    } catch (const std::exception& error) {
      ROS_ERROR("the topics of %s cannot be used: %s", server.c_str(), error.what());
    }
  });
}

ServerConnection::~ServerConnection()
{
  try {
    std::shared_ptr<Link> link;
    {
      const std::lock_guard<std::mutex> lock(shared_->mutex);
      shared_->ended = true;
      link.swap(shared_->link);
    }
    if (link) {
      masterThread().add([last = std::move(link)](const Cancellation&) mutable { last.reset(); });
    }
  } catch (const std::exception&) {  // no memory: it ends here
  }
}

void ServerConnection::connect(const std::string& server, Shared& shared)
{
  {
    const std::lock_guard<std::mutex> lock(shared.mutex);
    if (shared.ended) {
      return;
    }
  }
  const auto link = std::make_shared<Link>();
  const auto events = shared.events;
  ros::NodeHandle node;
  const auto receive = [&](const std::string& name, auto take) {
    using Take = decltype(take);
    using Message = typename Take::Message;
    TopicReceiver::Callbacks<Message> callbacks;
    callbacks.receive = [events, take](const boost::shared_ptr<const Message>& message,
                                       const Flag&) {
      const Time now = std::chrono::steady_clock::now();
      events->add([message, take, now](ServerWatch& watch) { take(watch, *message, now); });
    };
    callbacks.refuse = [](const std::string&, const Flag&) {};
    link->subscriptions.push_back(
        link->receiver.subscribe<Message>(node, server + "/" + name, QUEUE, callbacks));
  };
  for (std::size_t i = 0; i < ACTION_COUNT; ++i) {
    const auto action = static_cast<NavigationAction>(i);
    const std::string name = server + "/" + nameOf(action);
    link->cancel[i] = node.advertise<actionlib_msgs::GoalID>(name + "/cancel", 1);
  }
  link->choice = node.advertise<mbf_msgs::MoveBaseGoal>(server + "/goal_defaults", 1, true);

  for (std::size_t i = 0; i < ACTION_COUNT; ++i) {
    const auto action = static_cast<NavigationAction>(i);
    receive(joined(nameOf(action), "/status"), TakeStatus{action});
  }
  receive("move_base/goal", Take<mbf_msgs::MoveBaseActionGoal>());
  receive("exe_path/goal", Take<mbf_msgs::ExePathActionGoal>());
  receive("get_path/goal", Take<mbf_msgs::GetPathActionGoal>());
  receive("recovery/goal", Take<mbf_msgs::RecoveryActionGoal>());
  receive("move_base/feedback", TakeWithTime<mbf_msgs::MoveBaseActionFeedback>());
  receive("exe_path/feedback", TakeWithTime<mbf_msgs::ExePathActionFeedback>());
  receive("move_base/result", Take<mbf_msgs::MoveBaseActionResult>());
  receive("exe_path/result", Take<mbf_msgs::ExePathActionResult>());
  receive("get_path/result", Take<mbf_msgs::GetPathActionResult>());

  TopicReceiver::Callbacks<DiagnosticArray> diagnostics;
  diagnostics.receive = [events, server](const boost::shared_ptr<const DiagnosticArray>& message,
                                         const Flag&) {
    if (const auto status = ownStatus(*message, server)) {
      const Time now = std::chrono::steady_clock::now();
      events->add([status, now](ServerWatch& watch) {
        watch.takeDiagnosis(isReady(*status), status->level == 0, status->message, now);
      });
    }
  };
  diagnostics.refuse = [](const std::string&, const Flag&) {};
  link->subscriptions.push_back(
      link->receiver.subscribe<DiagnosticArray>(node, "/diagnostics", 100, diagnostics));

  const std::lock_guard<std::mutex> lock(shared.mutex);
  if (!shared.ended) {
    if (shared.choice) {
      link->choice.publish(*shared.choice);
    }
    shared.link = link;
  }
}

void ServerConnection::deliver(ServerWatch& watch)
{
  std::deque<Events::Event> come;
  {
    const std::lock_guard<std::mutex> lock(shared_->events->mutex);
    come.swap(shared_->events->waiting);
  }
  for (const Events::Event& event : come) {
    event(watch);
  }
}

bool ServerConnection::cancel(NavigationAction action)
{
  const auto link = shared_->now();
  const ros::Publisher* publisher =
      link ? &link->cancel[static_cast<std::size_t>(action)] : nullptr;
  if (!publisher || publisher->getNumSubscribers() == 0) {
    return false;
  }
  publisher->publish(actionlib_msgs::GoalID());  // neither id nor stamp: all of them
  return true;
}

bool ServerConnection::hearsCancel() const
{
  const auto link = shared_->now();
  return link && std::any_of(std::begin(link->cancel), std::end(link->cancel),
                             [](const auto& cancel) { return cancel.getNumSubscribers() > 0; });
}

void ServerConnection::choose(const std::string& planner, const std::string& controller)
{
  mbf_msgs::MoveBaseGoal choice;
  choice.planner = planner;
  choice.controller = controller;
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  shared_->choice = choice;
  if (shared_->link) {
    shared_->link->choice.publish(choice);
  }
}

std::size_t ServerConnection::choiceReceivers() const
{
  const auto link = shared_->now();
  return link ? link->choice.getNumSubscribers() : 0;
}

}  // namespace rviz_mesh_plugin
