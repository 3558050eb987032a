#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include <ros/callback_queue.h>
#include <ros/header.h>
#include <ros/master.h>
#include <ros/ros.h>
#include <ros/service_traits.h>
#include <ros/spinner.h>
#include <boost/function.hpp>

/// Service servers of all manners, for tests.
namespace service_servers {

inline bool waitFor(const std::function<bool()>& condition, double seconds = 30.0)
{
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (condition()) {
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return condition();
}

/// Real servers, answering on threads of their own.
class Servers
{
 public:
  Servers() : spinner_(4, &queue_)
  {
    node_handle_.setCallbackQueue(&queue_);
    spinner_.start();
  }
  ~Servers() { spinner_.stop(); }

  template <class Service>
  ros::ServiceServer serve(
      const std::string& name,
      const boost::function<bool(typename Service::Request&, typename Service::Response&)>& answer)
  {
    return node_handle_.advertiseService<typename Service::Request, typename Service::Response>(
        name, answer);
  }

 private:
  ros::CallbackQueue queue_;
  ros::NodeHandle node_handle_;
  ros::AsyncSpinner spinner_;
};

/// Holds a server's answer back. Its end waits until all are through.
class Gate
{
 public:
  ~Gate()
  {
    open();
    std::unique_lock<std::mutex> lock(mutex_);
    opened_.wait(lock, [this]() { return inside_ == 0; });
  }

  void open()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_open_ = true;
    opened_.notify_all();
  }

  void pass()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    ++inside_;
    ++reached;
    opened_.wait(lock, [this]() { return is_open_; });
    --inside_;
    opened_.notify_all();
  }

  std::atomic<int> reached{0};

 private:
  std::mutex mutex_;
  std::condition_variable opened_;
  bool is_open_ = false;
  int inside_ = 0;
};

/// Takes calls, answers a part of what it announces and closes the connection; as often as asked.
class DyingServer
{
 public:
  template <class Service>
  static DyingServer* of(const std::string& name)
  {
    return new DyingServer(name, ros::service_traits::datatype<Service>(),
                           ros::service_traits::md5sum<Service>());
  }

  ~DyingServer()
  {
    XmlRpc::XmlRpcValue request, response, payload;
    request[0] = "/dying";
    request[1] = name_;
    request[2] = uri_;
    ros::master::execute("unregisterService", request, response, payload, false);
    shutdown(socket_, SHUT_RDWR);
    thread_.join();
    close(socket_);
  }

  std::atomic<int> calls{0};

 private:
  DyingServer(const std::string& name, const std::string& type, const std::string& md5)
      : name_(name), type_(type), md5_(md5), socket_(socket(AF_INET, SOCK_STREAM, 0))
  {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    if (bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        listen(socket_, 8) != 0 ||
        getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
      throw std::runtime_error("no socket");
    }
    uri_ = "rosrpc://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this]() { serve(); });
    XmlRpc::XmlRpcValue request, response, payload;
    request[0] = "/dying";
    request[1] = name_;
    request[2] = uri_;
    request[3] = "http://127.0.0.1:1/";
    ros::master::execute("registerService", request, response, payload, false);
  }

  void serve()
  {
    while (true) {
      const int peer = accept(socket_, nullptr, nullptr);
      if (peer < 0) {
        return;
      }
      ++calls;
      char unread[4096];
      recv(peer, unread, sizeof(unread), 0);
      const ros::M_string fields = {{"type", type_}, {"md5sum", md5_}, {"callerid", "/dying"}};
      boost::shared_array<std::uint8_t> bytes;
      std::uint32_t size = 0;
      ros::Header::write(fields, bytes, size);
      std::string answer(reinterpret_cast<const char*>(&size), sizeof(size));
      answer.append(reinterpret_cast<const char*>(bytes.get()), size);
      answer += '\1';
      const std::uint32_t announced = 1000;
      answer.append(reinterpret_cast<const char*>(&announced), sizeof(announced));
      answer += "only this";
      send(peer, answer.data(), answer.size(), MSG_NOSIGNAL);
      recv(peer, unread, sizeof(unread), 0);  // the request
      close(peer);
    }
  }

  std::string name_, type_, md5_, uri_;
  int socket_;
  std::thread thread_;
};

}  // namespace service_servers
