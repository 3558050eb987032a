#include "ros_client/topic_receiver.h"

#include <deque>
#include <mutex>
#include <utility>

#include <ros/callback_queue.h>
#include <ros/console.h>

#include "threads/work_thread.h"

namespace rviz_mesh_plugin {
namespace {

/// roscpp loses a subscription that begins while another thread ends the last one of its topic.
std::mutex& subscribing()
{
  static std::mutex mutex;
  return mutex;
}

}  // namespace

/// Messages of roscpp, and tasks to do between two of them. Tasks end subscriptions, for which
/// roscpp locks its queue: they have to be destroyed without that lock, and so wait beside it.
class TopicReceiver::Queue
{
 public:
  using Task = std::function<void()>;

  ros::CallbackQueue& messages() { return messages_; }

  /// Where the thread has ended the task is dropped.
  void add(Task task)
  {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (is_closed_) {
        return;
      }
      tasks_.push_back(std::move(task));
    }
    messages_.addCallback(boost::make_shared<Turn>(*this));
  }

  /// The thread.
  void work(const Cancellation& cancellation)
  {
    while (!cancellation.flag()) {
      try {
        messages_.callOne(ros::WallDuration(1.0));
      } catch (const std::exception& error) {
        ROS_ERROR("a message is lost: %s", error.what());
      }
    }
    messages_.disable();
    messages_.clear();
    std::deque<Task> dropped;  // destroyed after the lock
    const std::lock_guard<std::mutex> lock(mutex_);
    is_closed_ = true;
    tasks_.swap(dropped);
  }

 private:
  /// Of the first task.
  class Turn : public ros::CallbackInterface
  {
   public:
    explicit Turn(Queue& queue) : queue_(queue) {}

    CallResult call() override
    {
      if (const Task task = queue_.takeFirst()) {
        task();
      }
      return Success;
    }

   private:
    Queue& queue_;  // that this is in
  };

  Task takeFirst()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (tasks_.empty()) {
      return nullptr;
    }
    Task first = std::move(tasks_.front());
    tasks_.pop_front();
    return first;
  }

  ros::CallbackQueue messages_;
  std::mutex mutex_;
  std::deque<Task> tasks_;
  bool is_closed_ = false;
};

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
    queue_->add([subscriber = subscriber_]() mutable {
      const std::lock_guard<std::mutex> lock(subscribing());
      subscriber.shutdown();
    });
  } catch (const std::exception&) {  // no memory: it ends here
  }
  subscriber_ = ros::Subscriber();
  queue_.reset();
}

TopicReceiver::TopicReceiver() : queue_(std::make_shared<Queue>()) {}

/// The thread ends when it has done what is in the queue before.
TopicReceiver::~TopicReceiver()
{
  if (!thread_) {
    return;
  }
  try {
    queue_->add([thread = thread_] { thread->cancel(); });
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
    thread->add([queue = queue_](const Cancellation& cancellation) { queue->work(cancellation); });
    thread_ = std::move(thread);
  }
  options.callback_queue = &queue_->messages();
  Subscription subscription;
  const std::lock_guard<std::mutex> lock(subscribing());
  subscription.subscriber_ = node_handle.subscribe(options);
  subscription.ended_ = ended;
  subscription.queue_ = queue_;
  return subscription;
}

}  // namespace rviz_mesh_plugin
