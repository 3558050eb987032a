#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/service_server.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>

/// The service save_map, on a thread of its own.
class SaveServer
{
 public:
  explicit SaveServer(const std::string& name_space) : spinner_(1, &queue_)
  {
    node_.setCallbackQueue(&queue_);
    service_ = node_.advertiseService(name_space + "/save_map", &SaveServer::save, this);
    spinner_.start();
  }

  ~SaveServer()
  {
    held = false;
    spinner_.stop();
    service_.shutdown();
  }

  std::atomic<int> calls{0};
  std::atomic<bool> held{false};  ///< it does not answer
  std::string refusal;            ///< empty: it is saved; is not to be changed during a call

 private:
  bool save(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response)
  {
    ++calls;
    while (held) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    response.success = refusal.empty();
    response.message = refusal;
    return true;
  }

  ros::CallbackQueue queue_;
  ros::NodeHandle node_;
  ros::ServiceServer service_;
  ros::AsyncSpinner spinner_;
};
