#include "map_server/map_file_watch.h"

#include <exception>
#include <utility>

#include "threads/work_lanes.h"

namespace rviz_mesh_plugin {

MapFileWatch::MapFileWatch(Look look)
    : look_(std::move(look)), lanes_(std::make_unique<WorkLanes>())
{
}

MapFileWatch::~MapFileWatch() = default;

void MapFileWatch::setPath(const std::string& path)
{
  if (answer_.valid()) {
    lanes_ = std::make_unique<WorkLanes>();
    answer_ = std::future<MapFile>();
  }
  path_ = path;
  file_ = nameOfFile(path);
  settled_ = false;
  problem_.clear();
  next_look_ = Clock::time_point();
}

bool MapFileWatch::update(Clock::time_point now)
{
  if (!answer_.valid()) {
    if (file_.state != MapFile::State::NOT_CHOSEN && file_.state != MapFile::State::BAD_NAME &&
        now >= next_look_) {
      ask(now);
    }
    return false;
  }
  if (answer_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    if (now - asked_ >= PATIENCE) {
      const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now - asked_);
      problem_ = "looking at " + file_.path + " takes long (" + std::to_string(seconds.count()) +
                 " s so far): if it is on a network share, is the server of that still there?";
    }
    return false;
  }
  take(now);
  return problem_.empty();
}

void MapFileWatch::ask(Clock::time_point now)
{
  next_look_ = now + INTERVAL;
  try {
    const auto look = std::make_shared<std::packaged_task<MapFile()>>(
        [look = look_, path = path_] { return look(path); });
    lanes_->add("look", [look] { (*look)(); });
    answer_ = look->get_future();
    asked_ = now;
  } catch (const std::exception& error) {  // no thread, no memory
    problem_ = file_.path + " cannot be looked at: " + error.what();
  }
}

void MapFileWatch::take(Clock::time_point now)
{
  const bool first = file_.state == MapFile::State::UNKNOWN;
  next_look_ = now + (first ? SECOND_LOOK : INTERVAL);
  try {
    MapFile seen = answer_.get();
    settled_ = seen.state == file_.state && seen.stamp == file_.stamp;
    file_ = std::move(seen);
    problem_.clear();
  } catch (const std::exception& error) {
    problem_ = file_.path + " cannot be looked at: " + error.what();
  }
}

}  // namespace rviz_mesh_plugin
