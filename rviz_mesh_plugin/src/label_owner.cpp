#include "rviz_mesh_plugin/label_owner.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <set>
#include <thread>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <mesh_msgs/MeshLabelColors.h>
#include <mesh_msgs/SetLabelColor.h>
#include <ros/names.h>
#include <ros/service.h>
#include <boost/function.hpp>

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t QUEUE = 10;
const ros::Duration PATIENCE(5.0);  // until the service is there

std::uint8_t toByte(float channel)
{
  return std::isfinite(channel) ? static_cast<std::uint8_t>(
                                      std::lround(255.0f * std::max(0.0f, std::min(channel, 1.0f))))
                                : 0;
}

LabelOwner::Colors convert(const mesh_msgs::MeshLabelColors& message)
{
  LabelOwner::Colors colors;
  for (std::size_t i = 0; i < std::min(message.labels.size(), message.colors.size()); ++i) {
    const auto& color = message.colors[i];
    colors[message.labels[i]] = {toByte(color.r), toByte(color.g), toByte(color.b), 255};
  }
  return colors;
}

}  // namespace

/// What threads of ROS and the one that calls the service use, too; it outlives them.
struct LabelOwner::Shared
{
  struct Request
  {
    std::string service;
    mesh_msgs::SetLabelColor call;
  };

  std::mutex mutex;
  std::condition_variable wake;
  std::map<std::string, Colors> colors;  ///< by uuid
  std::set<std::string> changed;         ///< uuids
  std::deque<Request> requests;
  std::string failure;
  bool is_working = false;
  bool is_over = false;
};

LabelOwner::LabelOwner() : shared_(std::make_shared<Shared>()) {}

LabelOwner::~LabelOwner()
{
  disconnect();
}

void LabelOwner::connect(ros::NodeHandle& node_handle, const std::string& name_space)
{
  disconnect();
  if (name_space.empty()) {
    return;
  }
  color_service_ = ros::names::append(name_space, "set_label_color");
  publisher_ = node_handle.advertise<mesh_msgs::MeshFaceClusterStamped>(
      ros::names::append(name_space, "cluster_label"), QUEUE);
  const std::shared_ptr<Shared> shared = shared_;
  const boost::function<void(const mesh_msgs::MeshLabelColors::ConstPtr&)> receive =
      [shared](const mesh_msgs::MeshLabelColors::ConstPtr& message) {
        Colors colors = convert(*message);
        const std::lock_guard<std::mutex> lock(shared->mutex);
        shared->colors[message->uuid] = std::move(colors);
        shared->changed.insert(message->uuid);
      };
  subscriber_ = node_handle.subscribe<mesh_msgs::MeshLabelColors>(
      ros::names::append(name_space, "label_colors"), QUEUE, receive);
}

void LabelOwner::disconnect()
{
  publisher_.shutdown();
  publisher_ = ros::Publisher();
  subscriber_.shutdown();
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    shared_->is_over = true;
    shared_->requests.clear();
  }
  shared_->wake.notify_all();
  shared_ = std::make_shared<Shared>();  // what is on its way arrives in the old one
}

void LabelOwner::store(const MeshData& mesh, const std::string& label,
                       const std::vector<std::uint32_t>& faces)
{
  mesh_msgs::MeshFaceClusterStamped message;
  message.header.frame_id = mesh.frame_id;
  message.header.stamp = ros::Time::now();
  message.uuid = mesh.uuid;
  message.cluster.label = label;
  message.cluster.face_indices = faces;
  message.override = true;
  publisher_.publish(message);
}

void LabelOwner::setColor(const std::string& uuid, const std::string& label, const Rgba8* color)
{
  Shared::Request request;
  request.service = color_service_;
  request.call.request.uuid = uuid;
  request.call.request.label = label;
  if (color) {
    request.call.request.color.r = color->red / 255.0f;
    request.call.request.color.g = color->green / 255.0f;
    request.call.request.color.b = color->blue / 255.0f;
    request.call.request.color.a = 1.0f;
  }
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  // Of a color that is dragged about, the newest counts.
  auto& requests = shared_->requests;
  requests.erase(std::remove_if(requests.begin(), requests.end(),
                                [&](const Shared::Request& other) {
                                  return other.call.request.label == label;
                                }),
                 requests.end());
  requests.push_back(request);
  if (!shared_->is_working) {
    // Detached: a service may never answer, and nobody waits for it then.
    std::thread(work, shared_).detach();
    shared_->is_working = true;
  }
  shared_->wake.notify_all();
}

void LabelOwner::work(const std::shared_ptr<Shared>& shared)
{
  std::unique_lock<std::mutex> lock(shared->mutex);
  while (!shared->is_over) {
    if (shared->requests.empty()) {
      shared->wake.wait(lock);
      continue;
    }
    Shared::Request request = shared->requests.front();
    shared->requests.pop_front();
    lock.unlock();
    std::string failure;
    try {
      if (!ros::service::waitForService(request.service, PATIENCE)) {
        failure = "nobody offers the service " + request.service;
      } else if (!ros::service::call(request.service, request.call)) {
        failure = "the service " + request.service + " refused it: see the log of its node";
      }
    } catch (const std::exception& error) {
      failure = error.what();
    }
    lock.lock();
    if (!failure.empty()) {
      shared->failure =
          "the color of '" + request.call.request.label + "' is not stored: " + failure;
      shared->changed.insert(request.call.request.uuid);  // as it was
    }
  }
}

std::optional<LabelOwner::Colors> LabelOwner::takeColors(const std::string& uuid)
{
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  if (shared_->changed.erase(uuid) == 0) {
    return std::nullopt;
  }
  return shared_->colors[uuid];
}

std::string LabelOwner::takeFailure()
{
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  std::string failure;
  failure.swap(shared_->failure);
  return failure;
}

}  // namespace rviz_mesh_plugin
