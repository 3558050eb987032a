#include "sources/label_client.h"

#include <exception>
#include <utility>

#include <mesh_msgs/DeleteLabel.h>
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
  delete_service_ = ros::names::append(name_space, "delete_label");
  publisher_ = node_handle.advertise<mesh_msgs::MeshFaceClusterStamped>(
      ros::names::append(name_space, "cluster_label"), EDIT_QUEUE);
}

void LabelClient::disconnect()
{
  publisher_.shutdown();
  publisher_ = ros::Publisher();
  requests_.clear();
  storing_.drop();
  waiting_.clear();
  deleting_.drop();
}

void LabelClient::store(const mesh_msgs::MeshFaceClusterStamped& edit)
{
  if (deleting_.isRunning() || !waiting_.empty()) {
    waiting_.push_back({edit, false});
  } else {
    publisher_.publish(edit);
  }
}

void LabelClient::remove(const mesh_msgs::MeshFaceClusterStamped& edit)
{
  waiting_.push_back({edit, true});
}

LabelClient::Deletion LabelClient::deleteLabels(const std::string& service,
                                                const std::vector<Edit>& edits,
                                                const Cancellation& cancellation)
{
  using mesh_msgs::DeleteLabel;
  Deletion deletion;
  for (const Edit& edit : edits) {
    DeleteLabel::Request request;
    request.uuid = edit.uuid;
    request.label = edit.cluster.label;
    std::string failure;
    try {
      const auto answer = ServiceCall(cancellation)
                              .call(service, {ServiceCall::typeOf<DeleteLabel>()},
                                    ros::serialization::serializeMessage(request));
      if (!answer) {
        deletion.not_offered.push_back(edit);
      } else if (!answer->refusal.empty()) {
        failure = service + " refuses it: " + answer->refusal;
      }
    } catch (const Canceled&) {
      throw;
    } catch (const std::exception& error) {
      failure = service + " cannot be called: " + error.what();
    }
    if (!failure.empty()) {
      deletion.failure = "the label '" + request.label + "' is not deleted: " + shortened(failure);
    }
  }
  return deletion;
}

/// Returns why a label is not deleted.
std::string LabelClient::workOff()
{
  std::string failure;
  if (const auto done = deleting_.take()) {
    failure = done->result ? done->result->failure : done->error;
    if (done->result) {
      for (const Edit& edit : done->result->not_offered) {
        publisher_.publish(edit);
      }
    }
  }
  while (!waiting_.empty() && !deleting_.isRunning()) {
    std::vector<Edit> removed;
    while (!waiting_.empty() && waiting_.front().removes) {
      removed.push_back(waiting_.front().edit);
      waiting_.pop_front();
    }
    if (removed.empty()) {
      publisher_.publish(waiting_.front().edit);
      waiting_.pop_front();
    } else {
      deleting_.start([service = delete_service_, removed](const Cancellation& cancellation) {
        return deleteLabels(service, removed, cancellation);
      });
    }
  }
  return failure;
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
  const std::string not_deleted = workOff();
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
  return !stored ? not_deleted : stored->result.value_or(stored->error);
}

}  // namespace rviz_mesh_plugin
