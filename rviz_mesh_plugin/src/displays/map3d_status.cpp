#include "displays/map3d_status.h"

#include <cmath>

#include <rviz/display_group.h>
#include <rviz/properties/status_list.h>
#include <rviz/properties/status_property.h>
#include <QLocale>

#include "displays/display_tree.h"

namespace rviz_mesh_plugin {
namespace {

constexpr std::size_t NOTES_SHOWN = 5;
/// A process that starts on a loaded machine may take seconds; longer, and something is wrong.
constexpr double START_SECONDS = 20.0;

std::string withUnit(std::uint64_t bytes)
{
  const QLocale locale = QLocale::c();
  return locale.formattedDataSize(static_cast<qint64>(bytes), 1, QLocale::DataSizeSIFormat)
      .toStdString();
}

std::string inSeconds(double seconds)
{
  return std::to_string(static_cast<long>(std::floor(seconds))) + " s";
}

/// Why there is no file that could be read; nothing where there is one.
OptionalStatus fileProblem(const FileState& file)
{
  using State = FileState::State;
  switch (file.state) {
    case State::NOT_CHOSEN:
      return StatusLine::warn(
          "No map file path specified! Click on the value of 'Map file path' and on "
          "'...', and choose a map (.h5) or a mesh (.ply, .obj, .stl, .off, .dae, .glb)");
    case State::UNKNOWN:
      return StatusLine::warn("looking at ", file.path);
    case State::MISSING:
      return StatusLine::error("Specified map file does not exist! There is nothing at ", file.path,
                               "; it is loaded as soon as it is there");
    case State::DIRECTORY:
      return StatusLine::error(file.path, " is a folder; choose a file in it");
    case State::NOT_REGULAR:
      return StatusLine::error(file.path,
                               " is not a file (but a device or the like); choose a map file");
    case State::UNREADABLE:
      return StatusLine::error(file.path, " may not be read; change its permissions (chmod +r)");
    case State::BAD_NAME:
      return StatusLine::error(file.path,
                               " contains ':=', which ROS takes for a remapping; rename it");
    case State::PRESENT:
      break;
  }
  return std::nullopt;
}

std::string textOf(const std::vector<std::string>& notes)
{
  std::string text;
  for (std::size_t i = 0; i < notes.size() && i < NOTES_SHOWN; ++i) {
    text += "; " + notes[i];
  }
  if (notes.size() > NOTES_SHOWN) {
    text += "; and " + std::to_string(notes.size() - NOTES_SHOWN) + " more";
  }
  return text;
}

bool isReady(const Map3DState& state)
{
  return state.started && state.progress.stage == MapProgress::Stage::READY;
}

StatusLine runningStatus(const Map3DState& state)
{
  const std::string process =
      "hdf5_map_server (process " + std::to_string(state.pid) + ", " + state.server + ")";
  switch (state.progress.stage) {
    case MapProgress::Stage::STARTING:
      if (state.seconds < START_SECONDS) {
        return StatusLine::ok("starting ", process);
      }
      return StatusLine::warn(
          process, " has said nothing for ", inSeconds(state.seconds),
          "; is the ROS master still there? 'Reset' does not end it: choose the file again to "
          "start anew");
    case MapProgress::Stage::READING:
      return StatusLine::ok(process, " has been reading for ", inSeconds(state.seconds));
    case MapProgress::Stage::READY:
      break;
  }
  return StatusLine::ok(process, " serves the file (", withUnit(state.file.size()), ")",
                        textOf(state.progress.notes));
}

}  // namespace

StatusLine mapStatus(const Map3DState& state)
{
  if (isReady(state)) {
    return StatusLine::ok(state.progress.text);
  }
  if (!state.started && !state.look_problem.empty()) {
    return StatusLine::warn(state.look_problem, "; it is loaded as soon as there is an answer");
  }
  if (const OptionalStatus problem = fileProblem(state.file)) {
    return *problem;
  }
  if (!state.problem.empty() || !state.ending.empty()) {
    return StatusLine::error("nothing is shown of ", state.file.path, "; line 'IO' tells why");
  }
  if (state.started && state.progress.stage == MapProgress::Stage::READING) {
    return StatusLine::warn("reading ", state.progress.text, ", ", inSeconds(state.seconds));
  }
  return StatusLine::warn("loading ", state.file.path, " (", withUnit(state.file.size()), ")");
}

OptionalStatus ioStatus(const Map3DState& state)
{
  if (!state.problem.empty()) {
    return StatusLine::error(state.problem);
  }
  if (!state.ending.empty()) {
    return StatusLine::error(
        "hdf5_map_server has ended: ", state.ending,
        "; it is started again when the file changes, and by 'Reset'",
        isReady(state) ? "; what it has served is still shown, edits are not stored" : "");
  }
  if (!state.started) {
    return std::nullopt;
  }
  if (!state.look_problem.empty()) {
    return StatusLine::warn(state.look_problem,
                            isReady(state) ? "; what was read of it is still shown" : "");
  }
  if (isReady(state) && state.file.state != FileState::State::PRESENT) {
    return StatusLine::warn(state.file.path,
                            " is gone or may not be read any more; what was read of it is still "
                            "shown: put it back, or choose another file");
  }
  if (!state.progress.failure.empty()) {
    return StatusLine::error("the file has changed, but what is in it now is not served: ",
                             state.progress.failure);
  }
  return runningStatus(state);
}

OptionalStatus labelStatus(const Map3DState& state)
{
  if (state.label && !state.label->stored) {
    return StatusLine::error("Error while saving label: ", state.label->text);
  }
  const std::string owner =
      state.progress.label_owner.empty() ? std::string() : "; " + state.progress.label_owner;
  if (state.label) {
    return StatusLine::ok(state.label->text, owner);
  }
  if (!isReady(state)) {
    return std::nullopt;
  }
  if (!owner.empty()) {
    return StatusLine::warn(state.progress.label_owner);
  }
  return StatusLine::ok(
      "labels that are edited here are stored at once, and put into the file when it is closed or "
      "save_map is called");
}

OptionalStatus partsStatus(const rviz::DisplayGroup& group)
{
  StatusLine worst;
  std::size_t count = 0;
  const auto look = [&](const rviz::Display& display, const rviz::Property& line) {
    const auto* status = dynamic_cast<const rviz::StatusProperty*>(&line);
    const auto level = status ? static_cast<StatusLine::Level>(status->getLevel()) : StatusLine::OK;
    if (level == StatusLine::OK) {
      return;
    }
    ++count;
    if (level > worst.level) {
      worst.level = level;
      worst.text = shortened(joined(display.getNameStd(), ", ", line.getNameStd(), ": ",
                                    line.getValue().toString().toStdString()));
    }
  };
  visitDisplays<rviz::Display>(&group, DisplayChoice::ENABLED, [&](const rviz::Display& display) {
    for (int i = 0; i < display.numChildren(); ++i) {
      const auto* lines = dynamic_cast<const rviz::StatusList*>(display.childAt(i));
      for (int j = 0; lines && j < lines->numChildren(); ++j) {
        look(display, *lines->childAt(j));
      }
    }
  });
  if (count == 0) {
    return std::nullopt;
  }
  if (count > 1) {
    worst.text += joined(" (and ", counted(count - 1, "line", "lines"), " more below)");
  }
  return worst;
}

}  // namespace rviz_mesh_plugin
