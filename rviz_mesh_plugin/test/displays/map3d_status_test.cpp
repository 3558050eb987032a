#include "displays/map3d_status.h"

#include <gtest/gtest.h>

#include "map_server/map_progress.h"

using rviz_mesh_plugin::errorLine;
using rviz_mesh_plugin::FileState;
using rviz_mesh_plugin::ioStatus;
using rviz_mesh_plugin::isRefusedLabel;
using rviz_mesh_plugin::LabelEvent;
using rviz_mesh_plugin::labelStatus;
using rviz_mesh_plugin::Map3DState;
using rviz_mesh_plugin::MapProgress;
using rviz_mesh_plugin::mapStatus;
using rviz_mesh_plugin::OptionalStatus;
using rviz_mesh_plugin::plainLine;
using rviz_mesh_plugin::StatusLine;
using rviz_mesh_plugin::takeProgress;
using Stage = rviz_mesh_plugin::MapProgress::Stage;
using State = rviz_mesh_plugin::FileState::State;

namespace {

Map3DState present()
{
  Map3DState state;
  state.file.state = State::PRESENT;
  state.file.path = "/maps/garden.ply";
  std::get<2>(state.file.stamp) = 1500000;
  return state;
}

Map3DState running()
{
  Map3DState state = present();
  state.started = true;
  state.pid = 77;
  state.server = "/rviz/map3d_1";
  state.seconds = 3.9;
  return state;
}

Map3DState ready()
{
  Map3DState state = running();
  takeProgress("ready: serving /maps/garden.ply: 4 vertices, 2 faces\nnote: 1 face left out",
               state.progress);
  return state;
}

void expectLine(const OptionalStatus& line, StatusLine::Level level, const std::string& words)
{
  ASSERT_TRUE(line);
  EXPECT_EQ(line->level, level) << line->text;
  EXPECT_NE(line->text.find(words), std::string::npos) << line->text;
}

}  // namespace

TEST(Progress, is_read_line_by_line)
{
  MapProgress progress;
  takeProgress("reading /maps/garden.ply (1.5 MB)", progress);
  EXPECT_EQ(progress.stage, Stage::READING);
  EXPECT_EQ(progress.text, "/maps/garden.ply (1.5 MB)");
  takeProgress("ready: serving it\nnote: one\nnote: two\nlabels: sent away\nfailed: too new",
               progress);
  EXPECT_EQ(progress.stage, Stage::READY);
  EXPECT_EQ(progress.text, "serving it");
  EXPECT_EQ(progress.notes, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(progress.label_owner, "sent away");
  EXPECT_EQ(progress.failure, "too new");
  takeProgress("ready: serving it\n\nsomething else\n", progress);  // nothing of before is left
  EXPECT_TRUE(progress.notes.empty());
  EXPECT_EQ(progress.label_owner + progress.failure, "");
  takeProgress("", progress);
  EXPECT_EQ(progress.text, "serving it");
}

TEST(Lines, are_freed_of_colors_and_dates)
{
  EXPECT_EQ(plainLine("\033[33m[WARN] [1795299381.098272]: cluster_label: refused: x\033[0m\n"),
            "cluster_label: refused: x");
  EXPECT_EQ(plainLine("[INFO] no date\r\n"), "[INFO] no date");
  EXPECT_EQ(plainLine("a [x]: b"), "a [x]: b");
  EXPECT_EQ(plainLine("\033[31"), "");
  EXPECT_EQ(plainLine("\033"), "");
  EXPECT_TRUE(isRefusedLabel("cluster_label: refused: x"));
  EXPECT_FALSE(isRefusedLabel("store/texture: refused: x"));
}

TEST(Lines, tell_why_a_process_ended)
{
  EXPECT_EQ(errorLine({"serving", "hdf5_map_server: error: no such file", "bye"}), "no such file");
  EXPECT_EQ(errorLine({"error: bad"}), "bad");
  EXPECT_EQ(errorLine({"Traceback", "there was an error: x", "ImportError: rospy"}),
            "ImportError: rospy");
  EXPECT_EQ(errorLine({}), "");
}

TEST(MapLine, says_what_to_do_with_each_file)
{
  Map3DState state;
  expectLine(mapStatus(state), StatusLine::WARN, "No map file path specified!");
  state.file.path = "/maps/x";
  for (const auto& expected :
       std::vector<std::pair<State, const char*>>{{State::MISSING, "does not exist"},
                                                  {State::DIRECTORY, "is a folder"},
                                                  {State::NOT_REGULAR, "not a file"},
                                                  {State::UNREADABLE, "may not be read"},
                                                  {State::BAD_NAME, "rename"}}) {
    state.file.state = expected.first;
    expectLine(mapStatus(state), StatusLine::ERROR, expected.second);
    expectLine(mapStatus(state), StatusLine::ERROR, "/maps/x");
  }
  EXPECT_FALSE(ioStatus(state));
  EXPECT_FALSE(labelStatus(state));
}

TEST(MapLine, says_that_nothing_is_known_of_the_file)
{
  Map3DState state;
  state.file.path = "/share/x.h5";
  state.file.state = State::UNKNOWN;
  expectLine(mapStatus(state), StatusLine::WARN, "looking at /share/x.h5");
  state.look_problem = "looking at /share/x.h5 takes long";
  expectLine(mapStatus(state), StatusLine::WARN, "takes long; it is loaded as soon as");
  EXPECT_FALSE(ioStatus(state));
  state = running();
  state.look_problem = "looking at it takes long";
  expectLine(mapStatus(state), StatusLine::WARN, "loading /maps/garden.ply");
  expectLine(ioStatus(state), StatusLine::WARN, "looking at it takes long");
  state = ready();
  state.look_problem = "looking at it takes long";
  expectLine(mapStatus(state), StatusLine::OK, "serving");
  expectLine(ioStatus(state), StatusLine::WARN, "takes long; what was read of it is still shown");
}

TEST(MapLine, follows_the_loading)
{
  expectLine(mapStatus(present()), StatusLine::WARN, "loading /maps/garden.ply (1.5 MB)");
  Map3DState state = running();
  expectLine(ioStatus(state), StatusLine::OK, "starting hdf5_map_server (process 77");
  state.seconds = 25.0;
  expectLine(ioStatus(state), StatusLine::WARN, "has said nothing for 25 s");
  takeProgress("reading /maps/garden.ply (1.5 MB)", state.progress);
  expectLine(mapStatus(state), StatusLine::WARN, "reading /maps/garden.ply (1.5 MB), 25 s");
  expectLine(ioStatus(state), StatusLine::OK, "has been reading for 25 s");
  state = ready();
  expectLine(mapStatus(state), StatusLine::OK, "serving /maps/garden.ply: 4 vertices, 2 faces");
  expectLine(ioStatus(state), StatusLine::OK, "serves the file (1.5 MB); 1 face left out");
  state.progress.notes.assign(8, "note");
  expectLine(ioStatus(state), StatusLine::OK, "; and 3 more");
}

TEST(IoLine, tells_what_went_wrong)
{
  Map3DState state = present();
  state.problem = "not found";
  expectLine(mapStatus(state), StatusLine::ERROR, "nothing is shown of /maps/garden.ply");
  expectLine(ioStatus(state), StatusLine::ERROR, "not found");

  state = running();
  state.ending = "it is not an HDF5 file (exit code 1)";
  expectLine(mapStatus(state), StatusLine::ERROR, "line 'IO' tells why");
  expectLine(ioStatus(state), StatusLine::ERROR, "has ended: it is not an HDF5 file (exit code 1)");

  state = ready();
  state.ending = "signal 9 (Killed)";
  expectLine(mapStatus(state), StatusLine::OK, "serving");
  expectLine(ioStatus(state), StatusLine::ERROR, "still shown, edits are not stored");

  state = ready();
  state.file.state = State::MISSING;
  expectLine(mapStatus(state), StatusLine::OK, "serving");
  expectLine(ioStatus(state), StatusLine::WARN, "gone");

  state = ready();
  state.progress.failure = "half a file";
  expectLine(ioStatus(state), StatusLine::ERROR, "not served: half a file");
}

TEST(LabelLine, tells_where_edits_go_and_what_became_of_them)
{
  EXPECT_FALSE(labelStatus(running()));
  Map3DState state = ready();
  expectLine(labelStatus(state), StatusLine::OK, "stored at once");
  state.progress.label_owner = "edits of labels are sent to /x";
  expectLine(labelStatus(state), StatusLine::WARN, "sent to /x");
  state.label = LabelEvent{true, "Successfully saved label 'tree_1' with 3 faces"};
  expectLine(labelStatus(state), StatusLine::OK, "'tree_1' with 3 faces; edits of labels are sent");
  state.label = LabelEvent{false, "cluster_label: refused: face 9"};
  expectLine(labelStatus(state), StatusLine::ERROR, "Error while saving label: cluster_label: ");
}
