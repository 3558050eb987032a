#include "sources/label_color_source.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <list>
#include <mutex>
#include <utility>
#include <vector>

#include <mesh_msgs/GetLabelColors.h>
#include <mesh_msgs/MeshLabelColors.h>
#include <ros/console.h>
#include <ros/exceptions.h>
#include <ros/names.h>

#include "conversion/validation.h"
#include "ros_client/service_call.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::uint32_t COLOR_QUEUE = 10;

/// Of more meshes than this, colors are not kept.
constexpr std::size_t MAX_MESHES = 8;

std::uint8_t toByte(float channel)
{
  return static_cast<std::uint8_t>(std::lround(255.0f * channel));
}

/// @throw RejectedMessage
OwnColors convert(const std::vector<std::string>& labels,
                  const std::vector<std_msgs::ColorRGBA>& colors)
{
  if (labels.size() != colors.size()) {
    throw RejectedMessage("there are " + std::to_string(colors.size()) + " colors for " +
                          std::to_string(labels.size()) + " labels; send one for each");
  }
  OwnColors own;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto is_bad = [](float channel) { return !(channel >= 0.0f && channel <= 1.0f); };
    if (is_bad(colors[i].r) || is_bad(colors[i].g) || is_bad(colors[i].b)) {
      throw RejectedMessage("the color of label " + std::to_string(i) + ", '" +
                            shortened(labels[i]) +
                            "', has a channel that is no number from 0 to 1");
    }
    own[labels[i]] = {toByte(colors[i].r), toByte(colors[i].g), toByte(colors[i].b), 255};
  }
  return own;
}

}  // namespace

/// What threads of ROS and the one that asks the service use, too.
struct LabelColorSource::Known
{
  struct OfMesh
  {
    std::string uuid;
    OwnColorsConstPtr colors;
    bool published = false;  ///< what the service says is older
  };

  std::mutex mutex;
  std::list<OfMesh> meshes;  ///< the last changed or used first
  std::string refusal;

  std::list<OfMesh>::iterator find(const std::string& uuid)
  {
    return std::find_if(meshes.begin(), meshes.end(),
                        [&](const OfMesh& mesh) { return mesh.uuid == uuid; });
  }

  void put(const std::string& uuid, OwnColors own, bool is_published)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    auto mesh = find(uuid);
    if (mesh == meshes.end()) {
      mesh = meshes.insert(meshes.begin(), OfMesh{uuid, nullptr, false});
    } else if (mesh->published && !is_published) {
      return;
    }
    mesh->published = mesh->published || is_published;
    if (!mesh->colors || *mesh->colors != own) {
      mesh->colors = std::make_shared<OwnColors>(std::move(own));
    }
    meshes.splice(meshes.begin(), meshes, mesh);
    if (meshes.size() > MAX_MESHES) {
      meshes.pop_back();
    }
    refusal.clear();
  }

  void refuse(const std::string& reason)
  {
    const std::lock_guard<std::mutex> lock(mutex);
    refusal = reason;
  }
};

std::string labelNamespace(const MeshSource& source)
{
  if (!source.service_namespace.empty() || source.labels_topic.empty()) {
    return source.service_namespace;
  }
  try {
    return ros::names::parentNamespace(ros::names::resolve(source.labels_topic));
  } catch (const ros::InvalidNameException&) {  // said where the topic is subscribed to
    return std::string();
  }
}

LabelColorSource::LabelColorSource() : known_(std::make_shared<Known>()) {}

void LabelColorSource::connect(ros::NodeHandle& node_handle, const std::string& name_space)
{
  if (name_space.empty()) {
    disconnect();
    return;
  }
  if (connected_ && name_space == namespace_) {
    return;
  }
  disconnect();
  if (name_space != namespace_) {
    clear();
    namespace_ = name_space;
  }
  TopicReceiver::Callbacks<mesh_msgs::MeshLabelColors> callbacks;
  callbacks.receive = [known = known_](const auto& message, const auto& /*ended*/) {
    try {
      known->put(message->uuid, convert(message->labels, message->colors), true);
    } catch (const RejectedMessage& rejected) {
      known->refuse(rejected.what());
    }
  };
  callbacks.refuse = [known = known_](const std::string& reason, const auto& /*ended*/) {
    known->refuse(reason);
  };
  subscription_ = receiver_.subscribe(node_handle, ros::names::append(name_space, "label_colors"),
                                      COLOR_QUEUE, callbacks);
  connected_ = true;
}

void LabelColorSource::disconnect()
{
  if (!connected_) {
    return;
  }
  connected_ = false;
  subscription_.end();
  asked_.clear();
  thread_.cancel();
  const auto before = known_;  // what is on its way arrives there
  known_ = std::make_shared<Known>();
  const std::lock_guard<std::mutex> lock(before->mutex);
  for (const Known::OfMesh& mesh : before->meshes) {
    known_->meshes.push_back({mesh.uuid, mesh.colors, false});
  }
}

void LabelColorSource::clear()
{
  disconnect();
  known_ = std::make_shared<Known>();
  namespace_.clear();
}

void LabelColorSource::request(const std::string& uuid)
{
  if (!connected_ || asked_.count(uuid) != 0) {
    return;
  }
  thread_.add([known = known_, uuid, service = ros::names::append(namespace_, "get_label_colors")](
                  const Cancellation& cancellation) { ask(*known, service, uuid, cancellation); });
  asked_.insert(uuid);
}

/// Where that fails, nothing is wrong: there are owners without colors.
void LabelColorSource::ask(Known& known, const std::string& service, const std::string& uuid,
                           const Cancellation& cancellation)
{
  try {
    using mesh_msgs::GetLabelColors;
    GetLabelColors::Request request;
    request.uuid = uuid;
    const auto answer = ServiceCall(cancellation).callPatiently<GetLabelColors>(service, request);
    if (answer && answer->refusal.empty()) {
      const auto response = answer->read<GetLabelColors::Response>();
      known.put(uuid, convert(response.labels, response.colors), false);
    } else if (answer) {
      ROS_WARN("%s refuses to tell colors: %s", service.c_str(),
               shortened(answer->refusal).c_str());
    }
  } catch (const Canceled&) {
  } catch (const RejectedMessage& rejected) {
    known.refuse(service + " answers: " + rejected.what());
  } catch (const std::exception& error) {
    ROS_WARN("%s cannot be called: %s", service.c_str(), error.what());
  }
}

OwnColorsConstPtr LabelColorSource::colors(const std::string& uuid) const
{
  const std::lock_guard<std::mutex> lock(known_->mutex);
  const auto found = known_->find(uuid);
  if (found == known_->meshes.end()) {
    return nullptr;
  }
  known_->meshes.splice(known_->meshes.begin(), known_->meshes, found);
  return found->colors;
}

OptionalStatus LabelColorSource::status() const
{
  const std::lock_guard<std::mutex> lock(known_->mutex);
  if (known_->refusal.empty()) {
    return std::nullopt;
  }
  return StatusLine::error("colors of labels ignored: ", known_->refusal);
}

}  // namespace rviz_mesh_plugin
