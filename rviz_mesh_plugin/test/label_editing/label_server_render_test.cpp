// Labels edited as the panel does, with the hdf5_map_server of a Map3D display.
#include <chrono>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <rviz/visualization_manager.h>

#include "displays/cluster_label_display.h"
#include "label_editing/label_session.h"
#include "support/map3d_fixture.h"

using rviz_mesh_plugin::FileLabels;
using rviz_mesh_plugin::LabelSession;
using rviz_mesh_plugin::readLabelFile;
using rviz_mesh_plugin::Rgba8;

namespace {

constexpr std::size_t FACES = 40;

class LabelServerTest : public Map3DFixture
{
 protected:
  static testing::AssertionResult until(LabelSession& session, const std::function<bool()>& done)
  {
    const bool is_done = spinUntil(
        [&] {
          session.work(nullptr);
          if (session.failed() > 0) {
            session.sendAgain();  // the server may not listen yet
          }
          return done();
        },
        TIMEOUT);
    return is_done ? testing::AssertionSuccess() : testing::AssertionFailure() << session.failure();
  }

  static testing::AssertionResult untilStored(LabelSession& session)
  {
    return until(session, [&] { return session.unstored() == 0; });
  }

  static bool same(const FileLabels& a, const FileLabels& b)
  {
    return a.size() == b.size() &&
           std::equal(a.begin(), a.end(), b.begin(), [](const auto& left, const auto& right) {
             return left.first == right.first && left.second.faces == right.second.faces &&
                    left.second.color == right.second.color;
           });
  }

  /// What is in the file, labels without faces among them.
  FileLabels saved(const std::string& map)
  {
    const std::string server = rviz_mesh_plugin::findMapServer();
    const std::string tool = server.substr(0, server.rfind('/')) + "/mesh_tool";
    const std::string out = path("labels.json");
    EXPECT_EQ(std::system(("cp " + path(map) + " " + path("copy.h5") + " && " + tool +
                           " labels export " + path("copy.h5") + " " + out + " -q --force")
                              .c_str()),
              0);
    return readLabelFile(out, FACES).labels;
  }
};

}  // namespace

TEST_F(LabelServerTest, edits_are_saved_and_are_the_same_everywhere)
{
  writeMap("a.h5", FACES / 2);
  Display* display = createMap(path("a.h5"));
  ASSERT_TRUE(waitForFaces(display, FACES));
  LabelSession session(manager());
  ASSERT_TRUE(until(session, [&] { return session.mesh() != nullptr; }));
  EXPECT_EQ(session.display(), display->labelDisplay());

  FileLabels expected;
  expected["tree_1"] = {{0, 1, 2}, Rgba8{10, 20, 30, 255}};
  expected["tree_2"] = {{5, 6}, std::nullopt};
  expected["car_1"] = {{7}, Rgba8{1, 2, 3, 255}};
  expected["wall_1"] = {{8, 9}, std::nullopt};
  EXPECT_EQ(session.import(std::make_shared<const FileLabels>(expected)), "");
  ASSERT_TRUE(untilStored(session));
  EXPECT_TRUE(same(session.content()(), expected));

  EXPECT_EQ(session.rename("tree_1", "bush_1"), "");
  EXPECT_EQ(session.merge({"tree_2", "wall_1"}, "wall_1"), "");
  EXPECT_EQ(session.setColor({"car_1"}, std::nullopt), "");
  ASSERT_TRUE(untilStored(session));
  expected["bush_1"] = expected["tree_1"];
  expected["wall_1"].faces = {5, 6, 8, 9};
  expected["car_1"].color.reset();
  expected.erase("tree_1");
  expected.erase("tree_2");
  EXPECT_TRUE(same(session.content()(), expected));
  EXPECT_GE(session.unsaved(), 5u);

  // Of what is deleted, nothing is left in the file.
  EXPECT_EQ(session.remove({"car_1"}), "");
  ASSERT_TRUE(untilStored(session));
  EXPECT_EQ(session.undo(), "undone: deleting 'car_1'");
  ASSERT_TRUE(untilStored(session));
  EXPECT_TRUE(same(session.content()(), expected));
  EXPECT_EQ(session.redo(), "done again: deleting 'car_1'");
  ASSERT_TRUE(untilStored(session));
  expected.erase("car_1");
  EXPECT_TRUE(same(session.content()(), expected));

  EXPECT_EQ(session.save(), "");
  ASSERT_TRUE(until(session, [&] { return !session.isSaving(); }));
  EXPECT_EQ(session.failure(), "");
  EXPECT_EQ(session.unsaved(), 0u);
  const FileLabels in_file = saved("a.h5");
  EXPECT_TRUE(same(in_file, expected)) << labelsToCsv(in_file);

  // Once more from the file, by another process.
  remove(display);
  ASSERT_TRUE(spinUntil([] { return children().empty(); }, TIMEOUT));
  display = createMap(path("a.h5"));
  LabelSession again(manager());
  EXPECT_TRUE(until(again, [&] { return same(again.content()(), expected); }))
      << labelsToCsv(again.content()());
}
