#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <sstream>
#include <string>

namespace rviz {
class Display;
}

namespace rviz_mesh_plugin {

/// Texts and numbers, one behind the other.
template <class... Parts>
std::string joined(const Parts&... parts)
{
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

/// "1 layer", "2 layers"
inline std::string counted(std::size_t count, const char* one, const char* many)
{
  return joined(count, " ", count == 1 ? one : many);
}

/// One line of the status tree: a sentence with the numbers and the way out. Levels are those of
/// RViz.
struct StatusLine
{
  enum Level
  {
    OK = 0,
    WARN = 1,
    ERROR = 2
  };
  Level level = OK;
  std::string text;

  template <class... Parts>
  static StatusLine ok(const Parts&... parts)
  {
    return {OK, joined(parts...)};
  }
  template <class... Parts>
  static StatusLine warn(const Parts&... parts)
  {
    return {WARN, joined(parts...)};
  }
  template <class... Parts>
  static StatusLine error(const Parts&... parts)
  {
    return {ERROR, joined(parts...)};
  }
};

/// No line at all where there is nothing to say.
using OptionalStatus = std::optional<StatusLine>;

/// A text of somebody else's on one line, and not longer than this.
/// @param control stands for characters that cannot be seen
std::string shortened(std::string text, std::size_t most = 300, char control = ' ');

/// A name that somebody else gave, in quotation marks and not longer than a line takes.
inline std::string quotedName(const std::string& name)
{
  constexpr std::size_t MOST = 100;
  return "'" + shortened(name, MOST) + "'";
}

/// What the displays within another one say while that has nothing to show.
StatusLine noMapOpen();

/// The lines of one display as they are shown: only changes go to RViz, so that they may be
/// reported every frame. GUI thread only.
class StatusLines
{
 public:
  /// @param display has to outlive this
  explicit StatusLines(rviz::Display* display) : display_(display) {}

  /// Shows, replaces or, where there is nothing to say, takes away a line.
  void report(const std::string& name, const OptionalStatus& status);

  /// Does what RViz, Qt or a timer asked for: nothing is thrown, the line "Display" says what went
  /// wrong, and goes on saying so until it is taken away.
  /// @return whether all went well
  bool attempt(const std::function<void()>& work);

  /// The same for what is done every frame: the line is taken away as soon as it goes well.
  void repeat(const std::function<void()>& work);

  /// To be called after Display::clearStatuses() and Display::reset(), which took the lines away.
  void forget() { lines_.clear(); }

 private:
  rviz::Display* display_;
  std::map<std::string, StatusLine> lines_;
  bool repeat_failed_ = false;
};

}  // namespace rviz_mesh_plugin
