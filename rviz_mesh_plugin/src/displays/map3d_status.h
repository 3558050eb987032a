#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/status_lines.h"
#include "map_server/file_watch.h"
#include "map_server/map_progress.h"

namespace rviz {
class DisplayGroup;
}

namespace rviz_mesh_plugin {

/// What the lines of Map3D are made of.
struct Map3DState
{
  FileState file;
  std::string look_problem;  ///< why nothing newer is known of the file; else empty
  std::string problem;       ///< why no process can be started
  bool started = false;      ///< a process has been started
  std::int64_t pid = 0;      ///< 0: it has ended
  std::string server;        ///< its namespace
  std::string ending;        ///< why it has ended
  double seconds = 0.0;      ///< since it was started
  MapProgress progress;
  std::optional<LabelEvent> label;
};

/// What is shown, or why nothing is.
StatusLine mapStatus(const Map3DState& state);
/// The file and the process that reads it.
OptionalStatus ioStatus(const Map3DState& state);
/// What is wrong with the displays in a group, which nobody sees while it is collapsed: how bad the
/// worst line is, which of which display, and how many more there are.
OptionalStatus partsStatus(const rviz::DisplayGroup& group);
/// Where edits of labels go, and what became of the newest one.
OptionalStatus labelStatus(const Map3DState& state);

}  // namespace rviz_mesh_plugin
