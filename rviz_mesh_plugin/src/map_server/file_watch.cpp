#include "map_server/file_watch.h"

#include <cerrno>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <utility>

#include <sys/stat.h>
#include <unistd.h>

#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/trim.hpp>

namespace rviz_mesh_plugin {
namespace {

FileState::State stateOf(const std::string& path, FileStamp& stamp)
{
  struct stat status;
  if (::stat(path.c_str(), &status) != 0) {
    return errno == EACCES ? FileState::State::UNREADABLE : FileState::State::MISSING;
  }
  stamp = FileStamp(status.st_dev, status.st_ino, status.st_size,
                    status.st_mtim.tv_sec * INT64_C(1000000000) + status.st_mtim.tv_nsec);
  if (S_ISDIR(status.st_mode)) {
    return FileState::State::DIRECTORY;
  }
  if (!S_ISREG(status.st_mode)) {
    return FileState::State::NOT_REGULAR;
  }
  return ::access(path.c_str(), R_OK) == 0 ? FileState::State::PRESENT
                                           : FileState::State::UNREADABLE;
}

}  // namespace

std::string resolvedPath(const std::string& path)
{
  std::string name = boost::algorithm::trim_copy_if(path, boost::algorithm::is_any_of(" \t\r\n"));
  const std::string scheme = "file://";
  if (name.compare(0, scheme.size(), scheme) == 0) {
    name.erase(0, scheme.size());
  }
  if (name == "~" || name.compare(0, 2, "~/") == 0) {
    const char* home = std::getenv("HOME");
    name.replace(0, 1, home ? home : "");
  }
  std::error_code no_folder;
  const std::string absolute = std::filesystem::absolute(name, no_folder);
  return no_folder ? name : absolute;
}

FileState nameOfFile(const std::string& path)
{
  FileState file;
  file.path = resolvedPath(path);
  if (file.path.empty() || file.path == NO_MAP_FILE) {
    return file;
  }
  // What ROS takes for a remapping never reaches the node; nor does what follows a zero byte.
  const bool bad =
      file.path.find(":=") != std::string::npos || file.path.find('\0') != std::string::npos;
  file.state = bad ? FileState::State::BAD_NAME : FileState::State::UNKNOWN;
  return file;
}

FileState lookAtFile(const std::string& path)
{
  FileState file = nameOfFile(path);
  if (file.state == FileState::State::UNKNOWN) {
    file.state = stateOf(file.path, file.stamp);
  }
  return file;
}

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
