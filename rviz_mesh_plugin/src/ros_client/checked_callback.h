#pragma once

#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include <ros/subscription_callback_helper.h>
#include <boost/shared_ptr.hpp>

#include "ros_client/message_lengths.h"

namespace rviz_mesh_plugin {

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

}  // namespace rviz_mesh_plugin
