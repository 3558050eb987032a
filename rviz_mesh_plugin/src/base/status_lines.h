#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

namespace rviz {
class Display;
}

namespace rviz_mesh_plugin {

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
};

/// No line at all where there is nothing to say.
using OptionalStatus = std::optional<StatusLine>;

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

  /// Takes away all lines reported here.
  void clear();

  /// To be called after Display::clearStatuses() and Display::reset(), which took the lines away.
  void forget() { lines_.clear(); }

 private:
  rviz::Display* display_;
  std::map<std::string, StatusLine> lines_;
};

}  // namespace rviz_mesh_plugin
