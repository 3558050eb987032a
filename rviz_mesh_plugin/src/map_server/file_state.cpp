#include "map_server/file_state.h"

#include <cerrno>
#include <cstdlib>

#include <sys/stat.h>
#include <unistd.h>

namespace rviz_mesh_plugin {
namespace {

constexpr const char* SPACES = " \t\r\n";

std::string stripped(const std::string& text)
{
  const std::size_t first = text.find_first_not_of(SPACES);
  if (first == std::string::npos) {
    return std::string();
  }
  return text.substr(first, text.find_last_not_of(SPACES) - first + 1);
}

std::string absolute(const std::string& path)
{
  char folder[4096];
  if (path[0] == '/' || !::getcwd(folder, sizeof(folder))) {
    return path;
  }
  return std::string(folder) + "/" + path;
}

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
  std::string name = stripped(path);
  const std::string scheme = "file://";
  if (name.compare(0, scheme.size(), scheme) == 0) {
    name.erase(0, scheme.size());
  }
  if (name.empty()) {
    return name;
  }
  if (name == "~" || name.compare(0, 2, "~/") == 0) {
    const char* home = std::getenv("HOME");
    name.replace(0, 1, home ? home : "");
  }
  return name.empty() ? name : absolute(name);
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

}  // namespace rviz_mesh_plugin
