#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <ros/node_handle.h>
#include <ros/subscribe_options.h>
#include <ros/subscriber.h>
#include <ros/subscription_callback_helper.h>
#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>

#include "ros_client/message_lengths.h"

namespace ros {
class CallbackQueue;
}

namespace rviz_mesh_plugin {

class WorkThread;

/// Those in this process who receive a topic. roscpp deserializes a message once for all of them,
/// so that a message which cannot be read is to be told to all. Thread safe.
class TopicReaders
{
 public:
  using Refuse = std::function<void(const std::string& reason)>;

  /// The one of this process.
  static std::shared_ptr<TopicReaders> instance();

  /// @param refuse is called as long as somebody else keeps it, too
  void add(const std::string& topic, const std::shared_ptr<const Refuse>& refuse);
  void refuse(const std::string& topic, const std::string& reason);

 private:
  std::mutex mutex_;
  std::map<std::string, std::vector<std::weak_ptr<const Refuse>>> by_topic_;
};

/// What roscpp calls for a subscription (ros::SubscribeOptions::helper). Messages of publishers in
/// this process arrive without a copy. In contrast to roscpp's own it reads no message that lies
/// about a length, and nothing is thrown into the callback queue: both are refused.
template <class Message>
class CheckedCallback
    : public ros::SubscriptionCallbackHelperT<const boost::shared_ptr<const Message>&>
{
  using Base = ros::SubscriptionCallbackHelperT<const boost::shared_ptr<const Message>&>;

 public:
  using Refuse = TopicReaders::Refuse;

  /// @param topic resolved
  CheckedCallback(const std::string& topic, const typename Base::Callback& receive,
                  const Refuse& refuse)
      : Base(receive), topic_(topic), refuse_(std::make_shared<Refuse>(refuse))
  {
    readers_->add(topic_, refuse_);
  }

  /// What is thrown here is logged by roscpp, with the publisher's name.
  ros::VoidConstPtr deserialize(
      const ros::SubscriptionCallbackHelperDeserializeParams& params) override
  {
    try {
      const std::string reason = findFalseLength<Message>(params.buffer, params.length);
      if (!reason.empty()) {
        throw std::length_error(reason);
      }
      return Base::deserialize(params);
    } catch (const std::bad_alloc&) {
      readers_->refuse(topic_, "there is not enough memory for a message of " +
                                   std::to_string(params.length) + " bytes");
      throw;
    } catch (const std::exception& error) {
      readers_->refuse(topic_, error.what());
      throw;
    }
  }

  void call(ros::SubscriptionCallbackHelperCallParams& params) override
  {
    try {
      Base::call(params);
    } catch (const std::exception& error) {
      try {
        (*refuse_)(std::string("the message could not be taken: ") + error.what());
      } catch (const std::exception&) {  // no memory to say so
      }
    }
  }

 private:
  const std::string topic_;
  const std::shared_ptr<const Refuse> refuse_;
  const std::shared_ptr<TopicReaders> readers_ = TopicReaders::instance();
};

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
