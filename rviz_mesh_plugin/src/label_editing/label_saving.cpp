#include "label_editing/label_saving.h"

#include <iterator>
#include <set>
#include <stdexcept>

#include <ros/console.h>
#include <ros/names.h>
#include <std_srvs/Trigger.h>

#include "base/status_lines.h"
#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::chrono::seconds SAVE_PATIENCE(120);

/// Asks who stores labels in this namespace to write them into the map; false: nobody is there.
/// @throw std::runtime_error that says why they are not saved; Canceled
bool saveLabels(const std::string& name_space, const Cancellation& cancellation)
{
  using std_srvs::Trigger;
  const std::string service = ros::names::append(name_space, "save_map");
  const auto answer = ServiceCall(cancellation).callPatiently<Trigger>(service, Trigger::Request());
  if (!answer) {
    return false;
  }
  if (!answer->refusal.empty()) {
    throw std::runtime_error(service + " refuses it: " + shortened(answer->refusal));
  }
  Trigger::Response response;
  try {
    response = answer->read<Trigger::Response>();
  } catch (const RejectedMessage& rejected) {
    throw std::runtime_error(service + " answers: " + rejected.what());
  }
  if (!response.success) {
    throw std::runtime_error(service + " says: " + shortened(response.message));
  }
  return true;
}

}  // namespace

void LabelSaving::addStored(const MeshId& mesh, const std::string& label,
                            const std::string& name_space)
{
  unsaved_[{mesh, label}] = {name_space, ++changes_};
}

std::string LabelSaving::save(const std::string& name_space)
{
  std::set<std::string> namespaces;
  for (const auto& label : unsaved_) {
    namespaces.insert(label.second.name_space);
  }
  if (!name_space.empty()) {
    namespaces.insert(name_space);
  }
  if (namespaces.empty()) {
    return "there is nothing to save: no display shows labels";
  }
  if (isSaving()) {
    return "labels are being saved already";
  }
  failure_.clear();
  for (const std::string& owner : namespaces) {
    Saving& saving = saving_[owner];
    saving.until = changes_;
    saving.since = Clock::now();
    saving.task.start(
        [owner](const Cancellation& cancellation) { return saveLabels(owner, cancellation); });
  }
  return {};
}

bool LabelSaving::work(const std::string& name_space)
{
  bool changed = false;
  for (auto saving = saving_.begin(); saving != saving_.end();) {
    const std::string failure = take(saving->first, saving->second, saving->first == name_space);
    if (!failure.empty()) {
      failure_ += (failure_.empty() ? "" : "; ") + failure;
    }
    if (saving->second.task.isRunning()) {
      ++saving;
    } else {
      saving = saving_.erase(saving);
      changed = true;
    }
  }
  return changed;
}

/// Forgets what has been saved. Returns what went wrong.
std::string LabelSaving::take(const std::string& name_space, Saving& saving, bool is_edited)
{
  const auto outcome = saving.task.take();
  if (!outcome && Clock::now() - saving.since <= SAVE_PATIENCE) {
    return {};
  }
  const std::string service = ros::names::append(name_space, "save_map");
  if (!outcome) {
    saving.task.drop();
    return "labels are not saved: " + service + " has not answered for two minutes";
  }
  if (!outcome->result) {
    return "labels are not saved: " + outcome->error;
  }
  const bool is_there = *outcome->result;
  if (!is_there && is_edited) {
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
