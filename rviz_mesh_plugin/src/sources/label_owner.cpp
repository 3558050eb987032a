#include "sources/label_owner.h"

#include <exception>
#include <map>
#include <mutex>
#include <utility>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <mesh_msgs/SetLabelColor.h>
#include <ros/names.h>

#include "sources/label_service.h"
#include "sources/service_log.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t EDIT_QUEUE = 10;

/// What went wrong; empty: nothing.
std::string call(const std::string& service, const mesh_msgs::SetLabelColor::Request& request,
                 const Cancellation& cancellation)
{
  const auto answer = callLabelService<mesh_msgs::SetLabelColor>(service, request, cancellation);
  if (!answer) {
    return "nobody offers the service " + service;
  }
  return answer->refusal.empty() ? "" : service + " refuses it: " + answer->refusal;
}

}  // namespace

/// What the thread that calls the service uses, too.
struct LabelOwner::Shared
{
  std::mutex mutex;
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
      ros::names::append(name_space, "cluster_label"), EDIT_QUEUE);
}

void LabelOwner::disconnect()
{
  publisher_.shutdown();
  publisher_ = ros::Publisher();
  if (cancellation_) {
    cancellation_->set();
    cancellation_.reset();
    lanes_.reset();
  }
  shared_ = std::make_shared<Shared>();  // what is on its way arrives in the old one
}

void LabelOwner::store(const MeshData& mesh, const std::string& label,
                       const std::vector<std::uint32_t>& faces, bool override)
{
  mesh_msgs::MeshFaceClusterStamped message;
  message.header.frame_id = mesh.frame_id;
  message.header.stamp = ros::Time::now();
  message.uuid = mesh.uuid;
  message.cluster.label = label;
  message.cluster.face_indices = faces;
  message.override = override;
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
  }
}

std::string LabelOwner::takeFailure()
{
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  std::string failure;
  failure.swap(shared_->failure);
  return failure;
}

}  // namespace rviz_mesh_plugin
