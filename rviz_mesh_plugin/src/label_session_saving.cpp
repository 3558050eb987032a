// A part of the session: has labels written into maps.
#include <iterator>
#include <set>
#include <stdexcept>
#include <utility>

#include <ros/console.h>
#include <ros/names.h>
#include <std_srvs/Trigger.h>

#include "rviz_mesh_plugin/label_service.h"
#include "rviz_mesh_plugin/label_session.h"
#include "rviz_mesh_plugin/message_lengths.h"
#include "rviz_mesh_plugin/service_log.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::chrono::seconds SAVE_PATIENCE(120);

/// Asks who stores labels in this namespace to write them into the map; false: nobody is there.
/// @throw std::runtime_error that says why they are not saved; Cancelled
bool saveLabels(const std::string& name_space, const Cancellation& cancellation)
{
  using std_srvs::Trigger;
  const std::string service = ros::names::append(name_space, "save_map");
  const auto answer = callLabelService<Trigger>(service, Trigger::Request(), cancellation);
  if (!answer) {
    return false;
  }
  if (!answer->refusal.empty()) {
    throw std::runtime_error(service + " refuses it: " + shortened(answer->refusal));
  }
  const ros::SerializedMessage& bytes = answer->response;
  const std::string reason =
      findFalseLength<Trigger::Response>(bytes.message_start, bytes.num_bytes);
  if (!reason.empty()) {
    throw std::runtime_error(service + " answers: " + reason);
  }
  Trigger::Response response;
  ros::serialization::deserializeMessage(bytes, response);
  if (!response.success) {
    throw std::runtime_error(service + " says: " + shortened(response.message));
  }
  return true;
}

}  // namespace

std::string LabelSession::save()
{
  std::set<std::string> namespaces;
  for (const auto& label : unsaved_) {
    namespaces.insert(label.second.name_space);
  }
  if (!namespace_.empty()) {
    namespaces.insert(namespace_);
  }
  if (namespaces.empty()) {
    return "there is nothing to save: no display shows labels";
  }
  if (isSaving()) {
    return "labels are being saved already";
  }
  save_failure_.clear();
  for (const std::string& name_space : namespaces) {
    startSaving(name_space);
  }
  return {};
}

void LabelSession::startSaving(const std::string& name_space)
{
  Saving saving;
  saving.until = changes_;
  saving.since = Clock::now();
  saving.cancellation = std::make_shared<Cancellation>();
  saving.task.start([name_space, cancellation = saving.cancellation] {
    return saveLabels(name_space, *cancellation);
  });
  saving_.emplace(name_space, std::move(saving));
}

void LabelSession::takeSaved()
{
  for (auto saving = saving_.begin(); saving != saving_.end();) {
    const std::string failure = takeSaved(saving->first, saving->second);
    if (!failure.empty()) {
      save_failure_ += (save_failure_.empty() ? "" : "; ") + failure;
    }
    if (saving->second.task.isRunning()) {
      ++saving;
    } else {
      saving = saving_.erase(saving);
      ++revision_;
    }
  }
}

/// Forgets what has been saved. Returns what went wrong.
std::string LabelSession::takeSaved(const std::string& name_space, Saving& saving)
{
  const auto outcome = saving.task.take();
  if (!outcome && Clock::now() - saving.since <= SAVE_PATIENCE) {
    return {};
  }
  const std::string service = ros::names::append(name_space, "save_map");
  if (!outcome) {
    saving.cancellation->set();
    saving.task.drop();
    return "labels are not saved: " + service + " has not answered for two minutes";
  }
  if (!outcome->result) {
    return "labels are not saved: " + outcome->error;
  }
  const bool is_there = *outcome->result;
  if (!is_there && name_space == namespace_) {
    return "labels are not saved: nobody offers the service " + service;
  }
  for (auto label = unsaved_.begin(); label != unsaved_.end();) {
    const bool is_over = label->second.name_space == name_space &&
                         (!is_there || label->second.change <= saving.until);
    label = is_over ? unsaved_.erase(label) : std::next(label);
  }
  if (is_there) {
    return {};
  }
  const std::string gone = "nobody offers the service " + service +
                           " any more: labels that were stored there are in the map, or in the "
                           "journal beside it, which its next server puts into it";
  ROS_WARN("%s", gone.c_str());  // RViz may be closing
  return gone;
}

}  // namespace rviz_mesh_plugin
