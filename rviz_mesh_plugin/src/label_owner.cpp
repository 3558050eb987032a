#include "rviz_mesh_plugin/label_owner.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <mutex>
#include <set>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <mesh_msgs/MeshLabelColors.h>
#include <mesh_msgs/SetLabelColor.h>
#include <ros/names.h>
#include <ros/serialization.h>
#include <ros/service_traits.h>
#include <boost/function.hpp>

#include "rviz_mesh_plugin/service_call.h"
#include "rviz_mesh_plugin/service_log.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t QUEUE = 10;
constexpr int TRIES = 5;  // a second apart, until the service is there

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

/// What went wrong; empty: nothing.
std::string call(const std::string& service, const mesh_msgs::SetLabelColor::Request& request,
                 const Cancellation& cancellation)
{
  namespace traits = ros::service_traits;
  const ServiceType type = {traits::datatype<mesh_msgs::SetLabelColor>(),
                            traits::md5sum<mesh_msgs::SetLabelColor>()};
  for (int i = 0; i < TRIES; ++i) {
    if (const auto address = lookUpService(service, cancellation)) {
      const ServiceAnswer answer =
          callService(service, *address, {type}, ros::serialization::serializeMessage(request),
                      cancellation, [](std::size_t, std::size_t) {});
      return answer.refusal.empty() ? "" : service + " refuses it: " + answer.refusal;
    }
    cancellation.wait(-1, 0, 1000);
  }
  return "nobody offers the service " + service;
}

}  // namespace

/// What threads of ROS and the one that calls the service use, too.
struct LabelOwner::Shared
{
  std::mutex mutex;
  std::map<std::string, Colors> colors;                               ///< by uuid
  std::set<std::string> changed;                                      ///< uuids
  std::map<std::string, mesh_msgs::SetLabelColor::Request> requests;  ///< by label
  std::string failure;
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
  if (cancellation_) {
    cancellation_->set();
    cancellation_.reset();
    lanes_.reset();
  }
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
  if (!cancellation_) {
    lanes_ = std::make_unique<WorkLanes>();
    cancellation_ = std::make_shared<Cancellation>();
  }
  mesh_msgs::SetLabelColor::Request request;
  request.uuid = uuid;
  request.label = label;
  if (color) {
    request.color.r = color->red / 255.0f;
    request.color.g = color->green / 255.0f;
    request.color.b = color->blue / 255.0f;
    request.color.a = 1.0f;
  }
  {
    const std::lock_guard<std::mutex> lock(shared_->mutex);
    // Of a color that is dragged about, the newest counts.
    shared_->requests[label] = request;
  }
  lanes_->add("colors", [shared = shared_, cancellation = cancellation_, name = color_service_,
                         label] { storeColor(*shared, name, label, *cancellation); });
}

void LabelOwner::storeColor(Shared& shared, const std::string& service, const std::string& label,
                            const Cancellation& cancellation)
{
  mesh_msgs::SetLabelColor::Request request;
  {
    const std::lock_guard<std::mutex> lock(shared.mutex);
    const auto newest = shared.requests.find(label);
    if (newest == shared.requests.end()) {
      return;  // it has been sent already
    }
    request = newest->second;
    shared.requests.erase(newest);
  }
  std::string failure;
  try {
    failure = call(service, request, cancellation);
  } catch (const Cancelled&) {
    return;
  } catch (const std::exception& error) {
    failure = service + " cannot be called: " + error.what();
  }
  if (!failure.empty()) {
    const std::lock_guard<std::mutex> lock(shared.mutex);
    shared.failure = "the color of '" + label + "' is not stored: " + shortened(failure);
    shared.changed.insert(request.uuid);  // as it was
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
