#include "ros_client/topic_receiver.h"

#include <mutex>

#include <ros/callback_queue.h>
#include <ros/console.h>

#include "threads/work_thread.h"

namespace rviz_mesh_plugin {
namespace {

/// Something to do on the thread, between two messages.
class Task : public ros::CallbackInterface
{
 public:
  explicit Task(std::function<void()> work) : work_(std::move(work)) {}

  CallResult call() override
  {
    work_();
    work_ = nullptr;
    return Success;
  }

 private:
  std::function<void()> work_;
};

/// roscpp loses a subscription that begins while another thread ends the last one of its topic.
std::mutex& subscribing()
{
  static std::mutex mutex;
  return mutex;
}

void work(ros::CallbackQueue& queue, const Cancellation& cancellation)
{
  while (!cancellation.flag()) {
    try {
      queue.callOne(ros::WallDuration(1.0));
    } catch (const std::exception& error) {
      ROS_ERROR("a message is lost: %s", error.what());
    }
  }
  queue.disable();
  queue.clear();
}

}  // namespace

TopicReceiver::Subscription& TopicReceiver::Subscription::operator=(Subscription&& other)
{
  end();
  queue_ = std::move(other.queue_);
  ended_ = std::move(other.ended_);
  subscriber_ = other.subscriber_;
  other.subscriber_ = ros::Subscriber();
  return *this;
}

void TopicReceiver::Subscription::end()
{
  if (!queue_) {
    return;
  }
  *ended_ = true;
  try {
    queue_->addCallback(boost::make_shared<Task>([subscriber = subscriber_]() mutable {
      const std::lock_guard<std::mutex> lock(subscribing());
      subscriber.shutdown();
    }));
  } catch (const std::exception&) {  // no memory: it ends here
  }
  subscriber_ = ros::Subscriber();
  queue_.reset();
}

TopicReceiver::TopicReceiver() : queue_(std::make_shared<ros::CallbackQueue>()) {}

/// The thread ends when it has done what is in the queue before.
TopicReceiver::~TopicReceiver()
{
  if (!thread_) {
    return;
  }
  try {
    queue_->addCallback(boost::make_shared<Task>([thread = thread_] { thread->cancel(); }));
  } catch (const std::exception&) {  // no memory
    thread_->cancel();
  }
}

TopicReceiver::Subscription TopicReceiver::subscribe(ros::NodeHandle& node_handle,
                                                     ros::SubscribeOptions& options,
                                                     const std::shared_ptr<Flag>& ended)
{
  if (!thread_) {
    auto thread = std::make_shared<WorkThread>("ROS messages");
    thread->add([queue = queue_](const Cancellation& cancellation) { work(*queue, cancellation); });
    thread_ = std::move(thread);
  }
  options.callback_queue = queue_.get();
  Subscription subscription;
  const std::lock_guard<std::mutex> lock(subscribing());
  subscription.subscriber_ = node_handle.subscribe(options);
  subscription.ended_ = ended;
  subscription.queue_ = queue_;
  return subscription;
}

}  // namespace rviz_mesh_plugin
