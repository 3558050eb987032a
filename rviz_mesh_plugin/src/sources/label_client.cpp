#include "sources/label_client.h"

#include <algorithm>
#include <exception>
#include <utility>

#include <mesh_msgs/DeleteLabel.h>
#include <ros/names.h>

#include "base/status_lines.h"
#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t EDIT_QUEUE = 10;
/// In a refusal, where somebody else has deleted the label before: that is what was wanted.
const char* const UNKNOWN = "there is no label ";

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

void LabelClient::connect(ros::NodeHandle& node_handle, const std::string& name_space)
{
  disconnect();
  if (name_space.empty()) {
    return;
  }
  color_service_ = ros::names::append(name_space, "set_label_color");
  delete_service_ = ros::names::append(name_space, "delete_label");
  publisher_.advertise(node_handle, ros::names::append(name_space, "cluster_label"), EDIT_QUEUE);
}

void LabelClient::disconnect()
{
  publisher_.shutdown();
  requests_.clear();
  storing_.drop();
  waiting_.clear();
  deleting_.drop();
  being_deleted_.clear();
}

void LabelClient::store(const SentEdit& edit)
{
  const std::string& label = edit.label;
  const bool waits = std::any_of(waiting_.begin(), waiting_.end(), [&](const Request& request) {
    return request.edit.label == label;
  });
  if (waits || isWaitedFor(label)) {
    wait(edit, false);
  } else {
    publisher_.publish(edit);
  }
}

void LabelClient::wait(const Edit& edit, bool removes)
{
  const auto replaced = [&](const Request& request) {
    return request.edit.label == edit.label && edit.override && (removes || !request.removes);
  };
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), replaced), waiting_.end());
  waiting_.push_back({edit, removes});
}

bool LabelClient::isWaitedFor(const std::string& label) const
{
  return std::find(being_deleted_.begin(), being_deleted_.end(), label) != being_deleted_.end();
}

void LabelClient::remove(const SentEdit& edit)
{
  wait(edit, true);
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
    request.label = edit.label;
    std::string failure;
    try {
      const auto answer = ServiceCall(cancellation)
                              .call(service, {ServiceCall::typeOf<DeleteLabel>()},
                                    ros::serialization::serializeMessage(request));
      if (!answer) {
        deletion.not_offered.push_back(edit);
      } else if (!answer->refusal.empty() && answer->refusal.find(UNKNOWN) == std::string::npos) {
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
std::string LabelClient::takeDeletion()
{
  std::string failure;
  if (const auto done = deleting_.take()) {
    failure = done->result ? done->result->failure : done->error;
    if (done->result) {
      for (const Edit& edit : done->result->not_offered) {
        publisher_.publish(edit);
      }
    }
    being_deleted_.clear();
  } else if (deleting_.isRunning() &&
             std::chrono::steady_clock::now() - deleting_since_ >= patience_) {
    deleting_.drop();
    failure =
        joined("whether the label '", being_deleted_.front(), "'",
               being_deleted_.size() > 1 ? joined(" (and ", being_deleted_.size() - 1, " more)")
                                         : std::string(),
               " is deleted is not known: ", delete_service_, " has not answered for ",
               std::chrono::duration_cast<std::chrono::seconds>(patience_).count(),
               " s; look whether it hangs, and delete again");
    being_deleted_.clear();
  }
  return failure;
}

void LabelClient::sendWaiting()
{
  if (deleting_.isRunning()) {
    return;
  }
  std::vector<Edit> removed;
  std::deque<Request> rest;
  for (Request& request : waiting_) {
    const std::string& label = request.edit.label;
    if (isWaitedFor(label)) {
      rest.push_back(std::move(request));
    } else if (request.removes) {
      being_deleted_.push_back(label);
      removed.push_back(std::move(request.edit));
    } else {
      publisher_.publish(request.edit);
    }
  }
  waiting_ = std::move(rest);
  if (!removed.empty()) {
    deleting_since_ = std::chrono::steady_clock::now();
    try {
      deleting_.start([service = delete_service_, removed](const Cancellation& cancellation) {
        return deleteLabels(service, removed, cancellation);
      });
    } catch (...) {  // without a thread: they wait for the next time
      being_deleted_.clear();
      for (auto edit = removed.rbegin(); edit != removed.rend(); ++edit) {
        waiting_.push_front({*edit, true});
      }
      throw;
    }
  }
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
  const std::string not_deleted = takeDeletion();
  sendWaiting();
  const auto stored = storing_.take();
  if (!storing_.isRunning() && !requests_.empty()) {
    storing_.start(
        [service = color_service_, requests = requests_](const Cancellation& cancellation) {
          std::string failure;
          for (const auto& label : requests) {
            const std::string newest = storeColor(service, label.second, cancellation);
            failure = newest.empty() ? failure : newest;
          }
          return failure;
        });
    requests_.clear();
  }
  const std::string not_stored = stored ? stored->result.value_or(stored->error) : std::string();
  return not_deleted.empty() || not_stored.empty() ? not_deleted + not_stored
                                                   : not_deleted + "; " + not_stored;
}

}  // namespace rviz_mesh_plugin
