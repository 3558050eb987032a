#include "map_server/file_watch.h"

#include <exception>
#include <utility>

namespace rviz_mesh_plugin {

FileWatch::FileWatch(Look look) : look_(std::move(look)) {}

void FileWatch::setPath(const std::string& path)
{
  answer_.drop();
  path_ = path;
  file_ = nameOfFile(path);
  settled_ = false;
  problem_.clear();
  next_look_ = Clock::time_point();
}

bool FileWatch::update(Clock::time_point now)
{
  if (!answer_.isRunning()) {
    if (file_.state != FileState::State::NOT_CHOSEN && file_.state != FileState::State::BAD_NAME &&
        now >= next_look_) {
      ask(now);
    }
    return false;
  }
  if (auto seen = answer_.take()) {
    take(std::move(*seen), now);
    return problem_.empty();
  }
  if (now - asked_ >= PATIENCE) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now - asked_);
    problem_ = "looking at " + file_.path + " takes long (" + std::to_string(seconds.count()) +
               " s so far): if it is on a network share, is the server of that still there?";
  }
  return false;
}

void FileWatch::ask(Clock::time_point now)
{
  next_look_ = now + INTERVAL;
  try {
    answer_.start([look = look_, path = path_](const Cancellation&) { return look(path); });
    asked_ = now;
  } catch (const std::exception& error) {  // no thread, no memory
    problem_ = file_.path + " cannot be looked at: " + error.what();
  }
}

void FileWatch::take(BackgroundTask<FileState>::Outcome seen, Clock::time_point now)
{
  const bool first = file_.state == FileState::State::UNKNOWN;
  next_look_ = now + (first ? SECOND_LOOK : INTERVAL);
  if (!seen.result) {
    problem_ = file_.path + " cannot be looked at: " + seen.error;
    return;
  }
  settled_ = seen.result->state == file_.state && seen.result->stamp == file_.stamp;
  file_ = std::move(*seen.result);
  problem_.clear();
}

}  // namespace rviz_mesh_plugin
