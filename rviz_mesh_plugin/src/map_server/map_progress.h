#pragma once

#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// What hdf5_map_server says of its map on the topic "progress".
struct MapProgress
{
  enum class Stage
  {
    STARTING,  ///< nothing has been said yet
    READING,
    READY
  };

  Stage stage = Stage::STARTING;
  std::string text;                ///< what is being read, or what is served
  std::vector<std::string> notes;  ///< what reading changed or left out
  std::string label_owner;         ///< another process that owns the labels; empty: this one
  std::string failure;             ///< why a newer file is not served; empty if it is
};

/// Takes a message of that topic over: one fact a line, as
/// "reading FILE", "ready: serving …", "labels: …", "note: …", "failed: …".
void takeProgress(const std::string& message, MapProgress& progress);

/// What became of an edit of a label.
struct LabelEvent
{
  bool stored = false;
  std::string text;  ///< a sentence
};

/// A line that hdf5_map_server has written, without color codes, ends of lines, date and level.
std::string plainLine(const std::string& line);

/// Of the lines that a process has written, the one that tells why it has ended; empty if none.
std::string errorLine(const std::vector<std::string>& lines);

/// Whether a line tells that a label has not been stored.
bool isRefusedLabel(const std::string& line);

}  // namespace rviz_mesh_plugin
