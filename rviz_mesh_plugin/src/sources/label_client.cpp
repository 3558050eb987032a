#include "sources/label_client.h"

#include <exception>
#include <map>
#include <mutex>
#include <utility>

#include <mesh_msgs/SetLabelColor.h>
#include <ros/names.h>

#include "base/status_lines.h"
#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t EDIT_QUEUE = 10;

/// What went wrong; empty: nothing.
std::string call(const std::string& service, const mesh_msgs::SetLabelColor::Request& request,
                 const Cancellation& cancellation)
{
  const auto answer =
      ServiceCall(cancellation).callPatiently<mesh_msgs::SetLabelColor>(service, request);
  if (!answer) {
    return "nobody offers the service " + service;
  }
  return answer->refusal.empty() ? "" : service + " refuses it: " + answer->refusal;
}

}  // namespace

mesh_msgs::MeshFaceClusterStamped labelEdit(const MeshData& mesh, const std::string& label,
                                            const std::vector<std::uint32_t>& faces, bool override)
{
  mesh_msgs::MeshFaceClusterStamped message;
  message.header.frame_id = mesh.frame_id;
  message.header.stamp = ros::Time::now();
  message.uuid = mesh.uuid;
  message.cluster.label = label;
  message.cluster.face_indices = faces;
  message.override = override;
  return message;
}

/// What the thread that calls the service uses, too.
struct LabelClient::Shared
{
  std::mutex mutex;
  std::map<std::string, mesh_msgs::SetLabelColor::Request> requests;  ///< by label
  std::string failure;
};

LabelClient::LabelClient() : shared_(std::make_shared<Shared>()) {}

LabelClient::~LabelClient()
{
  disconnect();
}

void LabelClient::connect(ros::NodeHandle& node_handle, const std::string& name_space)
{
  disconnect();
  if (name_space.empty()) {
    return;
  }
  color_service_ = ros::names::append(name_space, "set_label_color");
  publisher_ = node_handle.advertise<mesh_msgs::MeshFaceClusterStamped>(
      ros::names::append(name_space, "cluster_label"), EDIT_QUEUE);
}

void LabelClient::disconnect()
{
  publisher_.shutdown();
  publisher_ = ros::Publisher();
  thread_.cancel();
  shared_ = std::make_shared<Shared>();  // what is on its way arrives in the old one
}

void LabelClient::setColor(const std::string& uuid, const std::string& label, const Rgba8* color)
{
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
  thread_.add(
      [shared = shared_, service = color_service_, label](const Cancellation& cancellation) {
        storeColor(*shared, service, label, cancellation);
      });
}

void LabelClient::storeColor(Shared& shared, const std::string& service, const std::string& label,
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
  } catch (const Canceled&) {
    return;
  } catch (const std::exception& error) {
    failure = service + " cannot be called: " + error.what();
  }
  if (!failure.empty()) {
    const std::lock_guard<std::mutex> lock(shared.mutex);
    shared.failure = "the color of '" + label + "' is not stored: " + shortened(failure);
  }
}

std::string LabelClient::takeFailure()
{
  const std::lock_guard<std::mutex> lock(shared_->mutex);
  std::string failure;
  failure.swap(shared_->failure);
  return failure;
}

}  // namespace rviz_mesh_plugin
