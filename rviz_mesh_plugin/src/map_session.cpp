#include "rviz_mesh_plugin/map_session.h"

#include <exception>
#include <utility>

#include "rviz_mesh_plugin/map_server.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::chrono::milliseconds LOOK_EVERY(1000);
/// A file is served when its path has not changed for so long: somebody may still be typing.
constexpr std::chrono::milliseconds CHOICE_SETTLES(300);

}  // namespace

MapSession::MapSession(std::function<std::string()> find_program)
    : find_program_(std::move(find_program))
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
  file_ = lookAtFile(path);
  settled_ = true;  // most files have been there for long
  chosen_ = Clock::now();
  next_look_ = chosen_ + CHOICE_SETTLES;
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
  const Clock::time_point now = Clock::now();
  if (now < next_look_) {
    return;
  }
  next_look_ = now + LOOK_EVERY;
  look();
  const bool failed = !server_ || server_->process().ended();
  if (failed && file_.state == MapFile::State::PRESENT && settled_ && tried_ != file_.stamp) {
    start(nodes);
  }
}

void MapSession::look()
{
  const MapFile before = file_;
  file_ = lookAtFile(path_);
  settled_ = file_.state == before.state && file_.stamp == before.stamp;
}

void MapSession::start(ros::NodeHandle& nodes)
{
  tried_ = file_.stamp;
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
    server_ = std::make_unique<MapServer>(program, file_.path, nodes);
  } catch (const std::exception& error) {
    problem_ = std::string("hdf5_map_server cannot be started: ") + error.what();
  }
}

}  // namespace rviz_mesh_plugin
