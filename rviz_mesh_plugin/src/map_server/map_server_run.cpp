#include "map_server/map_server_run.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>

#include <unistd.h>

#include <ros/console.h>
#include <ros/master.h>
#include <ros/this_node.h>
#include <std_msgs/String.h>
#include <boost/function.hpp>

#include <mesh_msgs/MeshFaceCluster.h>

namespace rviz_mesh_plugin {
namespace {

constexpr const char* PACKAGE = "mesh_msgs_hdf5";
constexpr const char* NODE = "hdf5_map_server";

/// Never the same again, so that nothing of an earlier process is taken for something of this one.
std::string newNamespace()
{
  static unsigned int count = 0;
  return ros::this_node::getName() + "/map3d_" + std::to_string(::getpid()) + "_" +
         std::to_string(++count);
}

LabelEvent storedLabel(const mesh_msgs::MeshFaceCluster& cluster)
{
  const std::size_t count = cluster.face_indices.size();
  if (count == 0) {
    return LabelEvent{true,
                      "Successfully saved label '" + cluster.label + "': it has no faces now"};
  }
  return LabelEvent{true, "Successfully saved label '" + cluster.label + "' with " +
                              std::to_string(count) + (count == 1 ? " face" : " faces")};
}

/// The entries of a variable like PATH.
std::vector<std::string> folders(const char* variable)
{
  std::vector<std::string> found;
  const char* value = std::getenv(variable);
  const std::string text = value ? value : "";
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t end = std::min(text.find(':', start), text.size());
    if (end > start) {
      found.push_back(text.substr(start, end - start));
    }
    start = end + 1;
  }
  return found;
}

}  // namespace

/// What came from other threads.
class MapServerRun::Events
{
 public:
  void receive(const std_msgs::String::ConstPtr& message)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    progress_.push_back(message->data);
  }

  void receive(const mesh_msgs::MeshFaceCluster::ConstPtr& message)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    label_ = storedLabel(*message);
  }

  std::vector<std::string> take(std::optional<LabelEvent>& label)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<std::string> progress;
    progress.swap(progress_);
    if (label_) {
      label = std::move(label_);
      label_.reset();
    }
    return progress;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> progress_;
  std::optional<LabelEvent> label_;
};

MapServerRun::MapServerRun(const std::string& program, const std::string& file,
                           ros::NodeHandle& nodes)
    : namespace_(newNamespace()),
      started_(std::chrono::steady_clock::now()),
      queue_(std::make_shared<Events>()),
      process_(program, {file, std::string("__name:=") + NODE, "__ns:=" + namespace_},
               // where RViz itself was told otherwise than by its environment
               {"ROS_MASTER_URI=" + ros::master::getURI()})
{
  const std::shared_ptr<Events> queue = queue_;
  const boost::function<void(const std_msgs::String::ConstPtr&)> progress =
      [queue](const std_msgs::String::ConstPtr& message) { queue->receive(message); };
  const boost::function<void(const mesh_msgs::MeshFaceCluster::ConstPtr&)> label =
      [queue](const mesh_msgs::MeshFaceCluster::ConstPtr& message) { queue->receive(message); };
  subscribers_.push_back(nodes.subscribe<std_msgs::String>(namespace_ + "/progress", 10, progress));
  subscribers_.push_back(
      nodes.subscribe<mesh_msgs::MeshFaceCluster>(namespace_ + "/new_cluster_label", 10, label));
}

MapServerRun::~MapServerRun() = default;

void MapServerRun::poll(MapProgress& progress, std::optional<LabelEvent>& label)
{
  for (const std::string& message : queue_->take(label)) {
    takeProgress(message, progress);
  }
  for (const std::string& line : process_.takeLines()) {
    ROS_DEBUG("%s: %s", NODE, line.c_str());
    if (isRefusedLabel(line)) {
      label = LabelEvent{false, line};
    }
  }
}

std::chrono::steady_clock::duration MapServerRun::age() const
{
  return std::chrono::steady_clock::now() - started_;
}

std::string MapServerRun::ending() const
{
  if (!process_.ended()) {
    return std::string();
  }
  const std::string& how = process_.ending();
  const bool failed = how.rfind("exit code ", 0) == 0 && how != "exit code 0";
  const std::string reason = failed ? errorLine(process_.lastLines()) : std::string();
  return reason.empty() ? how : reason + " (" + how + ")";
}

MeshSource MapServerRun::source(const std::string& frame) const
{
  MeshSource source;
  source.geometry_topic = namespace_ + "/mesh/geometry";
  source.costs_topic = namespace_ + "/mesh/vertex_costs";
  source.face_costs_topic = namespace_ + "/mesh/face_costs";
  source.colors_topic = namespace_ + "/mesh/vertex_colors";
  source.labels_topic = namespace_ + "/new_cluster_label";
  source.service_namespace = namespace_;
  source.frame = frame;
  return source;
}

std::string findMapServer()
{
  std::vector<std::string> candidates;
  for (const std::string& prefix : folders("CMAKE_PREFIX_PATH")) {
    candidates.push_back(prefix + "/lib/" + PACKAGE + "/" + NODE);
  }
  for (const std::string& source : folders("ROS_PACKAGE_PATH")) {
    candidates.push_back(source + "/../lib/" + PACKAGE + "/" + NODE);  // <prefix>/share
    candidates.push_back(source + "/" + PACKAGE + "/nodes/" + NODE);
  }
  candidates.push_back(std::string("/usr/lib/") + PACKAGE + "/" + NODE);
  for (const std::string& candidate : candidates) {
    if (::access(candidate.c_str(), X_OK) == 0) {
      return candidate;
    }
  }
  return std::string();
}

}  // namespace rviz_mesh_plugin
