#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <typeinfo>
#include <utility>

#include <ros/console.h>
#include <ros/message_traits.h>
#include <ros/node_handle.h>
#include <ros/serialization.h>
#include <ros/subscribe_options.h>
#include <ros/subscriber.h>
#include <ros/subscription_callback_helper.h>
#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>

#include "ros_client/message_lengths.h"

namespace rviz_mesh_plugin {

class WorkThread;

/// What roscpp calls for a subscription (ros::SubscribeOptions::helper). In contrast to roscpp's
/// own it reads no message that lies about a length, and nothing is thrown, neither where a message
/// is read nor in the callback queue: it is refused. roscpp reads a message once for all callbacks
/// of one type in this process, frees its bytes, and knows by their number that it did: after a
/// failure with an empty message it would read them again, for the next one. So what is handed from
/// one to the others is no message, but the outcome of reading it, by which each is told in its
/// turn. That is of a type of its own, which subscribers of other plugins do not share.
template <class Message>
class CheckedCallback : public ros::SubscriptionCallbackHelper
{
 public:
  using Receive = std::function<void(const boost::shared_ptr<const Message>& message)>;
  using Refuse = std::function<void(const std::string& reason)>;

  /// @param topic resolved
  CheckedCallback(const std::string& topic, const Receive& receive, const Refuse& refuse)
      : topic_(topic), receive_(receive), refuse_(refuse)
  {
  }

  /// @return an Outcome, never null
  ros::VoidConstPtr deserialize(
      const ros::SubscriptionCallbackHelperDeserializeParams& params) override
  {
    try {
      const auto outcome = boost::make_shared<Outcome>();
      outcome->refusal = read(params, outcome->message);
      if (!outcome->refusal.empty()) {
        outcome->message.reset();
        const auto& header = params.connection_header;
        const auto publisher = header ? header->find("callerid") : ros::M_string::const_iterator();
        ROS_ERROR("a message on %s from [%s] is refused: %s", topic_.c_str(),
                  header && publisher != header->end() ? publisher->second.c_str() : "unknown",
                  outcome->refusal.c_str());
      }
      return outcome;
    } catch (const std::exception&) {  // not even for a reason
      return no_memory_;
    }
  }

  void call(ros::SubscriptionCallbackHelperCallParams& params) override
  {
    const auto outcome = boost::static_pointer_cast<const Outcome>(params.event.getConstMessage());
    try {
      if (!outcome->message) {
        refuse_(outcome->refusal);
        return;
      }
      receive_(outcome->message);
    } catch (const std::exception& error) {
      try {
        refuse_(std::string("the message could not be taken: ") + error.what());
      } catch (const std::exception&) {  // no memory to say so
      }
    }
  }

  const std::type_info& getTypeInfo() override { return typeid(Outcome); }
  bool isConst() override { return true; }
  bool hasHeader() override { return ros::message_traits::hasHeader<Message>(); }

 private:
  struct Outcome
  {
    boost::shared_ptr<const Message> message;  ///< null: refused
    std::string refusal;
  };

  /// @return why there is no message; empty where there is one
  static std::string read(const ros::SubscriptionCallbackHelperDeserializeParams& params,
                          boost::shared_ptr<const Message>& message)
  {
    try {
      std::string refusal = findFalseLength<Message>(params.buffer, params.length);
      if (refusal.empty()) {
        const auto read = boost::make_shared<Message>();
        ros::serialization::IStream stream(params.buffer, params.length);
        ros::serialization::deserialize(stream, *read);
        message = read;
      }
      return refusal;
    } catch (const std::bad_alloc&) {
      return "there is not enough memory for a message of " + std::to_string(params.length) +
             " bytes";
    } catch (const std::exception& error) {
      return error.what();
    }
  }

  const std::string topic_;
  const Receive receive_;
  const Refuse refuse_;
  const ros::VoidConstPtr no_memory_ =
      boost::make_shared<Outcome>(Outcome{nullptr, "there is not enough memory for a message"});
};

/// Receives topics on a thread of its own, which starts with the first subscription, so that
/// nobody waits for a message that is being read: to unsubscribe from a topic (and to destroy
/// this) takes no time, roscpp's part of that follows later on the thread.
class TopicReceiver
{
  class Queue;

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
    std::shared_ptr<Queue> queue_;  ///< null: it has ended
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

  std::shared_ptr<Queue> queue_;
  std::shared_ptr<WorkThread> thread_;
};

}  // namespace rviz_mesh_plugin
