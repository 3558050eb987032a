#include "sources/label_client.h"

#include <exception>
#include <utility>

#include <ros/names.h>

#include "base/status_lines.h"
#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t EDIT_QUEUE = 10;

/// What went wrong; empty: nothing. @throw Canceled
std::string storeColor(const std::string& service, const mesh_msgs::SetLabelColor::Request& request,
                       const Cancellation& cancellation)
{
  std::string failure;
  try {
    const auto answer =
        ServiceCall(cancellation).callPatiently<mesh_msgs::SetLabelColor>(service, request);
    if (!answer) {
      failure = "nobody offers the service " + service;
    } else if (!answer->refusal.empty()) {
      failure = service + " refuses it: " + answer->refusal;
    }
  } catch (const Canceled&) {
    throw;
  } catch (const std::exception& error) {
    failure = service + " cannot be called: " + error.what();
  }
  return failure.empty()
             ? failure
             : "the color of '" + request.label + "' is not stored: " + shortened(failure);
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
  requests_.clear();
  storing_.drop();
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
  requests_[label] = request;
}

std::string LabelClient::work()
{
  const auto stored = storing_.take();
  if (!storing_.isRunning() && !requests_.empty()) {
    storing_.start([service = color_service_,
                    requests = std::exchange(requests_, {})](const Cancellation& cancellation) {
      std::string failure;
      for (const auto& label : requests) {
        const std::string newest = storeColor(service, label.second, cancellation);
        failure = newest.empty() ? failure : newest;
      }
      return failure;
    });
  }
  return !stored ? std::string() : stored->result.value_or(stored->error);
}

}  // namespace rviz_mesh_plugin
