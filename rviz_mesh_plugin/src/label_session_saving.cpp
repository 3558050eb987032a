// A part of the session: has labels written into maps.
#include <set>
#include <stdexcept>

#include <ros/names.h>
#include <std_srvs/Trigger.h>

#include "rviz_mesh_plugin/label_service.h"
#include "rviz_mesh_plugin/label_session.h"
#include "rviz_mesh_plugin/message_lengths.h"
#include "rviz_mesh_plugin/service_log.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::chrono::seconds SAVE_PATIENCE(120);

/// Asks who stores labels in this namespace to write them into the map.
/// @throw std::runtime_error that says why they are not saved; Cancelled
void saveLabels(const std::string& name_space, const Cancellation& cancellation)
{
  using std_srvs::Trigger;
  const std::string service = ros::names::append(name_space, "save_map");
  const auto answer = callLabelService<Trigger>(service, Trigger::Request(), cancellation);
  if (!answer) {
    throw std::runtime_error("nobody offers the service " + service);
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
  if (saving_.isRunning()) {
    return "labels are being saved already";
  }
  save_failure_.clear();
  saving_until_ = changes_;
  saving_since_ = Clock::now();
  cancellation_ = std::make_shared<Cancellation>();
  saving_.start([namespaces, cancellation = cancellation_] {
    for (const std::string& name_space : namespaces) {
      saveLabels(name_space, *cancellation);
    }
    return true;
  });
  return {};
}

void LabelSession::takeSaved()
{
  if (saving_.isRunning() && Clock::now() - saving_since_ > SAVE_PATIENCE) {
    cancellation_->set();
    saving_.drop();
    save_failure_ = "labels are not saved: save_map has not answered for two minutes";
  }
  const auto outcome = saving_.take();
  if (!outcome) {
    return;
  }
  if (!outcome->result) {
    save_failure_ = "labels are not saved: " + outcome->error;
    return;
  }
  ++revision_;
  for (auto label = unsaved_.begin(); label != unsaved_.end();) {
    label = label->second.change <= saving_until_ ? unsaved_.erase(label) : std::next(label);
  }
}

}  // namespace rviz_mesh_plugin
