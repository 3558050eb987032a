#pragma once

#include <cstdint>
#include <string>
#include <tuple>

namespace rviz_mesh_plugin {

/// What the property holds as long as nobody has chosen a file.
constexpr const char* NO_MAP_FILE = "/path/to/map.h5";

/// Changes whenever another file takes a place or it is written to: device, inode, size, time.
using FileStamp = std::tuple<std::uint64_t, std::uint64_t, std::uint64_t, std::int64_t>;

/// What is at a path.
struct FileState
{
  enum class State
  {
    NOT_CHOSEN,
    UNKNOWN,  ///< nobody has looked yet
    MISSING,
    DIRECTORY,
    NOT_REGULAR,  ///< a device, a pipe …
    UNREADABLE,
    BAD_NAME,  ///< cannot be handed to a ROS node
    PRESENT
  };

  State state = State::NOT_CHOSEN;
  std::string path;  ///< absolute
  FileStamp stamp{};

  std::uint64_t size() const { return std::get<2>(stamp); }
};

/// The path as the system knows it: "~" is the home folder, a relative path counts from where RViz
/// was started; without spaces at the ends and the prefix "file://".
std::string resolvedPath(const std::string& path);

/// What the path alone tells: NOT_CHOSEN, BAD_NAME or UNKNOWN.
FileState nameOfFile(const std::string& path);

/// Looks at the file system, but opens nothing. On a network share this may take forever.
FileState lookAtFile(const std::string& path);

}  // namespace rviz_mesh_plugin
