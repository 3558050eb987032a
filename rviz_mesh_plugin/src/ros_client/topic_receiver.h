#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include <ros/node_handle.h>
#include <ros/subscribe_options.h>
#include <ros/subscriber.h>
#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>

#include "ros_client/checked_callback.h"

namespace ros {
class CallbackQueue;
}

namespace rviz_mesh_plugin {

class WorkThread;

/// Receives topics on a thread of its own, which starts with the first subscription, so that
/// nobody waits for a message that is being read: to unsubscribe from a topic (and to destroy
/// this) takes no time, roscpp's part of that follows later on the thread.
class TopicReceiver
{
 public:
  /// Set once nobody wants messages any more, also of a callback that runs at the time: what it
  /// has then to hand over has to be dropped.
  using Flag = std::atomic<bool>;

  /// A subscription, until it is destroyed.
  class Subscription
  {
   public:
    Subscription() = default;
    ~Subscription() { end(); }
    Subscription(Subscription&& other) { *this = std::move(other); }
    Subscription& operator=(Subscription&& other);

    void end();

   private:
    friend class TopicReceiver;
    std::shared_ptr<ros::CallbackQueue> queue_;  ///< null: it has ended
    std::shared_ptr<Flag> ended_;
    ros::Subscriber subscriber_;
  };

  template <class Message>
  struct Callbacks
  {
    std::function<void(const boost::shared_ptr<const Message>&, const Flag& ended)> receive;
    std::function<void(const std::string& reason, const Flag& ended)> refuse;
  };

  TopicReceiver();
  ~TopicReceiver();
  TopicReceiver(const TopicReceiver&) = delete;
  TopicReceiver& operator=(const TopicReceiver&) = delete;

  /// @param callbacks own what they use. @throw ros::Exception, std::system_error
  template <class Message>
  Subscription subscribe(ros::NodeHandle& node_handle, const std::string& topic,
                         std::uint32_t queue_size, const Callbacks<Message>& callbacks)
  {
    const auto ended = std::make_shared<Flag>(false);
    ros::SubscribeOptions options(node_handle.resolveName(topic), queue_size,
                                  ros::message_traits::md5sum<Message>(),
                                  ros::message_traits::datatype<Message>());
    options.helper = boost::make_shared<CheckedCallback<Message>>(
        options.topic,
        // The queue has to stay as long as roscpp may use it.
        [queue = queue_, ended, callbacks](const boost::shared_ptr<const Message>& message) {
          if (!*ended) {
            callbacks.receive(message, *ended);
          }
        },
        [ended, callbacks](const std::string& reason) { callbacks.refuse(reason, *ended); });
    return subscribe(node_handle, options, ended);
  }

 private:
  Subscription subscribe(ros::NodeHandle& node_handle, ros::SubscribeOptions& options,
                         const std::shared_ptr<Flag>& ended);

  std::shared_ptr<ros::CallbackQueue> queue_;
  std::shared_ptr<WorkThread> thread_;
};

}  // namespace rviz_mesh_plugin
