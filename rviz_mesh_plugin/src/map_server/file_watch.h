#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <tuple>

#include "threads/background_task.h"

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

/// Looks at a file about once a second, on a thread of its own: on a network share whose server is
/// gone a look may never end. Nobody waits for it, and until it ends the answer before stands. GUI
/// thread only.
class FileWatch
{
 public:
  using Clock = std::chrono::steady_clock;
  /// Called on another thread, even when this object is gone.
  using Look = std::function<FileState(const std::string& path)>;

  static constexpr std::chrono::milliseconds SECOND_LOOK{300};  ///< after the first one
  static constexpr std::chrono::milliseconds INTERVAL{1000};    ///< to further ones
  static constexpr std::chrono::milliseconds PATIENCE{3000};    ///< with a look that does not end

  explicit FileWatch(Look look = lookAtFile);

  /// Looks there from now on; a look elsewhere that has not ended is left alone.
  /// @param path as the user gave it, see resolvedPath()
  void setPath(const std::string& path);

  /// To be called often. @return whether there is a new answer
  bool update(Clock::time_point now);

  /// The newest answer; its state is UNKNOWN until there is one.
  const FileState& file() const { return file_; }
  /// Whether the file was the same at the two newest looks: nobody is writing it.
  bool settled() const { return settled_; }
  /// Why there is no newer answer, in a sentence; empty where there is no reason to worry.
  const std::string& problem() const { return problem_; }

 private:
  void ask(Clock::time_point now);
  void take(BackgroundTask<FileState>::Outcome seen, Clock::time_point now);

  Look look_;
  std::string path_;
  FileState file_;
  bool settled_ = false;
  std::string problem_;
  BackgroundTask<FileState> answer_{"map file", std::chrono::seconds(2)};
  Clock::time_point asked_{};
  Clock::time_point next_look_{};
};

}  // namespace rviz_mesh_plugin
