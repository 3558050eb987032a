#include "map_server/map_session.h"

#include <exception>
#include <mutex>
#include <utility>

#include <unistd.h>

#include <QStandardPaths>
#include <QStringList>

#include <ros/console.h>
#include <ros/master.h>
#include <ros/this_node.h>
#include <std_msgs/String.h>

#include <mesh_msgs/MeshFaceCluster.h>

#include "base/status_lines.h"

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
  return {true, joined("Successfully saved label '", cluster.label, "'",
                       count == 0 ? ": it has no faces now"
                                  : " with " + counted(count, "face", "faces"))};
}

/// The entries of a variable like PATH.
QStringList folders(const char* variable)
{
  QStringList folders = qEnvironmentVariable(variable).split(':');
  folders.removeAll(QString());
  return folders;
}

}  // namespace

/// What came from other threads.
struct MapServerRun::Events
{
  std::mutex mutex;
  std::vector<std::string> progress;
  std::optional<LabelEvent> label;
};

MapServerRun::MapServerRun(const std::string& program, const std::string& file,
                           ros::NodeHandle& nodes)
    : namespace_(newNamespace()),
      started_(std::chrono::steady_clock::now()),
      events_(std::make_shared<Events>()),
      process_(
          new MapServerProcess(QString::fromStdString(program),
                               {QString::fromStdString(file), QString("__name:=") + NODE,
                                "__ns:=" + QString::fromStdString(namespace_)},
                               // where RViz itself was told otherwise than by its environment
                               {"ROS_MASTER_URI=" + QString::fromStdString(ros::master::getURI())}))
{
  using Flag = TopicReceiver::Flag;
  TopicReceiver::Callbacks<std_msgs::String> progress;
  progress.receive = [events = events_](const auto& message, const Flag&) {
    const std::lock_guard<std::mutex> lock(events->mutex);
    events->progress.push_back(message->data);
  };
  progress.refuse = [](const std::string& reason, const Flag&) {
    ROS_WARN("what %s says of its progress cannot be read: %s", NODE, reason.c_str());
  };
  TopicReceiver::Callbacks<mesh_msgs::MeshFaceCluster> label;
  label.receive = [events = events_](const auto& message, const Flag&) {
    const std::lock_guard<std::mutex> lock(events->mutex);
    events->label = storedLabel(*message);
  };
  label.refuse = [events = events_](const std::string& reason, const Flag&) {
    const std::lock_guard<std::mutex> lock(events->mutex);
    events->label = LabelEvent{false, "a stored label cannot be read: " + reason};
  };
  subscriptions_.push_back(receiver_.subscribe(nodes, namespace_ + "/progress", 10, progress));
  subscriptions_.push_back(
      receiver_.subscribe(nodes, namespace_ + "/new_cluster_label", 10, label));
}

void MapServerRun::poll()
{
  {
    const std::lock_guard<std::mutex> lock(events_->mutex);
    for (const std::string& message : std::exchange(events_->progress, {})) {
      takeProgress(message, progress_);
    }
    if (events_->label) {
      label_ = std::exchange(events_->label, std::nullopt);
    }
  }
  for (const std::string& line : process_->takeLines()) {
    ROS_DEBUG("%s: %s", NODE, line.c_str());
    if (isRefusedLabel(line)) {
      label_ = LabelEvent{false, line};
    }
  }
}

std::chrono::steady_clock::duration MapServerRun::age() const
{
  return std::chrono::steady_clock::now() - started_;
}

std::string MapServerRun::ending() const
{
  const std::string& how = process_->ending();
  const bool failed = how.rfind("exit code ", 0) == 0 && how != "exit code 0";
  const std::string reason = failed ? errorLine(process_->lastLines()) : std::string();
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
  const QString folder = QString("/lib/") + PACKAGE;
  QStringList candidates;
  for (const QString& prefix : folders("CMAKE_PREFIX_PATH")) {
    candidates << prefix + folder;
  }
  for (const QString& source : folders("ROS_PACKAGE_PATH")) {
    candidates << source + "/.." + folder  // <prefix>/share
               << source + "/" + PACKAGE + "/nodes";
  }
  return QStandardPaths::findExecutable(NODE, candidates << "/usr" + folder).toStdString();
}

MapSession::MapSession(std::function<std::string()> find_program, FileWatch::Look look)
    : find_program_(std::move(find_program)), watch_(std::move(look))
{
}

void MapSession::setFile(const std::string& path)
{
  server_.reset();
  problem_.clear();
  tried_.reset();
  path_ = path;
  watch_.setPath(path);
}

void MapSession::retry()
{
  if (problem_.empty() && !(server_ && server_->process().ended())) {
    return;
  }
  setFile(path_);
}

void MapSession::update(ros::NodeHandle& nodes)
{
  if (server_) {
    server_->poll();
  }
  if (!watch_.update(FileWatch::Clock::now())) {
    return;
  }
  const bool failed = !server_ || server_->process().ended();
  if (failed && file().state == FileState::State::PRESENT && watch_.settled() &&
      tried_ != file().stamp) {
    start(nodes);
  }
}

void MapSession::start(ros::NodeHandle& nodes)
{
  tried_ = file().stamp;
  server_.reset();
  try {
    const std::string program = find_program_();
    if (program.empty()) {
      problem_ =
          "hdf5_map_server of the package mesh_msgs_hdf5 is not found: install or build that "
          "package, and start RViz in a shell where the setup.bash of its workspace was sourced";
      return;
    }
    problem_.clear();
    server_ = std::make_unique<MapServerRun>(program, file().path, nodes);
  } catch (const std::exception& error) {
    problem_ = std::string("hdf5_map_server cannot be started: ") + error.what();
  }
}

}  // namespace rviz_mesh_plugin
