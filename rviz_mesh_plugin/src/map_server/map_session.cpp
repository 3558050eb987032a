#include "map_server/map_session.h"

#include <exception>
#include <utility>

#include "map_server/map_server_run.h"

namespace rviz_mesh_plugin {

MapSession::MapSession(std::function<std::string()> find_program, FileWatch::Look look)
    : find_program_(std::move(find_program)), watch_(std::move(look))
{
}

MapSession::~MapSession() = default;

void MapSession::setFile(const std::string& path)
{
  server_.reset();
  problem_.clear();
  progress_ = MapProgress();
  label_.reset();
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
    server_->poll(progress_, label_);
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
  progress_ = MapProgress();
  label_.reset();
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
