// Map3D and its child process hdf5_map_server.
#include <future>
#include <memory>

#include <mesh_msgs/MeshFaceClusterStamped.h>
#include <ros/publisher.h>

#include "map_server/map_session.h"
#include "support/map3d_fixture.h"

namespace {

class Map3DServer : public Map3DFixture
{
 protected:
  static bool isThere(pid_t pid) { return ::kill(pid, 0) == 0; }

  /// Has faces labelled as tools do, and waits for what the display says of it.
  testing::AssertionResult label(Display* display, const std::string& text,
                                 const std::vector<std::uint32_t>& faces, const std::string& level,
                                 const std::string& words)
  {
    const std::string topic = display->session().server()->ns() + "/cluster_label";
    ros::Publisher publisher = node.advertise<mesh_msgs::MeshFaceClusterStamped>(topic, 1);
    mesh_msgs::MeshFaceClusterStamped message;
    message.uuid = "mesh";
    message.cluster.label = text;
    message.cluster.face_indices = faces;
    message.override = true;
    // More than once: right after the start of the server not everybody is connected.
    for (int i = 0; i < TIMEOUT / 2000; ++i) {
      publisher.publish(message);
      const auto said = [&] {
        const std::string line = status(display, "Label");
        return line.rfind(level + ":", 0) == 0 && line.find(words) != std::string::npos;
      };
      if (spinUntil(said, 2000)) {
        return testing::AssertionSuccess();
      }
    }
    return testing::AssertionFailure() << "'Label' is '" << status(display, "Label") << "'";
  }
};

}  // namespace

TEST_F(Map3DServer, shows_maps_and_labels_them)
{
  writeMap("a.h5", 3);
  Display* display = createMap(path("a.h5"));
  EXPECT_TRUE(waitForStatus(display, "Map", "Ok", "8 vertices, 6 faces"));
  EXPECT_TRUE(waitForStatus(display, "IO", "Ok", "serves the file"));
  EXPECT_TRUE(waitForStatus(display, "Label", "Ok", "stored at once"));
  EXPECT_TRUE(waitForFaces(display, 6));
  EXPECT_EQ(display->meshDisplay()->mesh()->frame_id, "map");

  EXPECT_TRUE(
      label(display, "tree_1", {0, 1}, "Ok", "Successfully saved label 'tree_1' with 2 faces"));
  EXPECT_TRUE(label(display, "tree_2", {0, 6}, "Error", "Error while saving label: cluster_label"));

  // A second display of the same file: the first one's process has the labels.
  Display* second = createMap(path("a.h5"), "Second");
  EXPECT_TRUE(waitForStatus(second, "Label", "Warn", display->session().server()->ns()));
  EXPECT_TRUE(waitForFaces(second, 6));
  // The very same mesh: it is in memory once.
  EXPECT_EQ(second->meshDisplay()->mesh(), display->meshDisplay()->mesh());
  EXPECT_TRUE(label(second, "tree_3", {4}, "Ok", "label 'tree_3' with 1 face;"));
  remove(display);
  EXPECT_TRUE(spinUntil([] { return children().size() == 1; }, TIMEOUT));
  // The process has put the labels into the file, and the other one has them now.
  EXPECT_TRUE(waitForStatus(second, "IO", "Ok", "serves the file"));
  const std::string command =
      "/usr/bin/python3 -c \"import h5py, sys; f = h5py.File(sys.argv[1], "
      "'r'); assert list(f['mesh/labels/tree/1'][()].ravel()) == [0, 1] "
      "and '2' not in f['mesh/labels/tree']\" " +
      path("a.h5");
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST_F(Map3DServer, tells_what_is_wrong_and_goes_on_when_it_is_right)
{
  write("a.h5", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 5\n");
  Display* display = createMap(path("a.h5"));
  EXPECT_TRUE(waitForStatus(display, "IO", "Error", "git lfs"));
  EXPECT_TRUE(waitForStatus(display, "Map", "Error", "line 'IO' tells why"));
  write("a.h5", "this is no map");
  EXPECT_TRUE(waitForStatus(display, "IO", "Error", "HDF5"));
  EXPECT_TRUE(spinUntil([] { return children().empty(); }, TIMEOUT));
  writeMap("a.h5", 3);
  EXPECT_TRUE(waitForStatus(display, "Map", "Ok", "6 faces"));
  EXPECT_TRUE(waitForFaces(display, 6));
  EXPECT_TRUE(waitForStatus(display, "IO", "Ok", "serves"));

  // Another mesh in its place is loaded by the same process.
  const pid_t server = serverOf(display);
  writeMap("b.h5", 5);
  ASSERT_EQ(std::rename(path("b.h5").c_str(), path("a.h5").c_str()), 0);
  EXPECT_TRUE(waitForStatus(display, "Map", "Ok", "10 faces"));
  EXPECT_TRUE(waitForFaces(display, 10));
  EXPECT_EQ(serverOf(display), server);
  write("a.h5", "this is no map");
  EXPECT_TRUE(waitForStatus(display, "IO", "Error", "is not served"));
  EXPECT_TRUE(waitForStatus(display, "Map", "Ok", "10 faces"));
  ::unlink(path("a.h5").c_str());
  EXPECT_TRUE(waitForStatus(display, "IO", "Warn", "is gone"));
  EXPECT_TRUE(waitForFaces(display, 10));
}

TEST_F(Map3DServer, says_what_reading_has_left_out)
{
  std::string text = strip(1);
  text.insert(text.find("element face"), "comment TextureFile nowhere.png\n");
  write("a.ply", text);
  Display* display = createMap(path("a.ply"));
  EXPECT_TRUE(waitForStatus(display, "Map", "Ok", "2 faces"));
  EXPECT_TRUE(
      waitForStatus(display, "IO", "Ok", "a.ply: left out: 1 textures, for want of coordinates"));
  EXPECT_NE(status(display, "IO").find(" serves the file ("), std::string::npos);
}

TEST_F(Map3DServer, survives_the_death_of_its_process)
{
  write("a.ply", strip(3));
  Display* display = createMap(path("a.ply"));
  ASSERT_TRUE(waitForFaces(display, 6));
  const pid_t killed = serverOf(display);
  ASSERT_GT(killed, 0);
  ::kill(killed, SIGKILL);
  EXPECT_TRUE(waitForStatus(display, "IO", "Error", "has ended: signal 9 (Killed)"));
  EXPECT_TRUE(waitForFaces(display, 6));  // what is shown stays
  spin(2500);
  EXPECT_EQ(serverOf(display), 0);  // and it is not started in a circle
  display->reset();
  EXPECT_TRUE(waitForStatus(display, "IO", "Ok", "serves"));
  EXPECT_TRUE(waitForFaces(display, 6));
  EXPECT_GT(serverOf(display), 0);
}

TEST_F(Map3DServer, leaves_no_process_behind)
{
  write("a.ply", strip(3));
  write("b.ply", strip(4));
  Display* display = createMap();
  for (int i = 0; i < 20; ++i) {
    choose(display, path(i % 2 ? "a.ply" : "b.ply"));
    spin(i % 5 == 0 ? 400 : 20);  // some are started, and ended in the middle of it
  }
  EXPECT_TRUE(waitForFaces(display, 6));
  EXPECT_TRUE(spinUntil([] { return children().size() == 1; }, TIMEOUT));
  EXPECT_EQ(children().front(), serverOf(display));
  choose(display, "");
  EXPECT_TRUE(waitForStatus(display, "Map", "Warn", "No map file path specified!"));
  EXPECT_TRUE(waitForFaces(display, 0));
  EXPECT_TRUE(spinUntil([] { return children().empty(); }, TIMEOUT));
}

TEST_F(Map3DServer, ends_in_the_middle_of_loading)
{
  write("a.ply", strip(200000));
  for (const int milliseconds : {0, 350, 1000}) {
    Display* display = createMap(path("a.ply"));
    spin(milliseconds);
    if (milliseconds == 1000) {
      EXPECT_TRUE(spinUntil([&] { return serverOf(display) > 0; }, TIMEOUT));
    }
    remove(display);
    EXPECT_TRUE(spinUntil([] { return children().empty(); }, TIMEOUT));
  }
}

TEST_F(Map3DServer, that_is_not_installed_is_explained)
{
  write("a.ply", strip(3));
  rviz_mesh_plugin::MapSession session([] { return std::string(); });
  session.setFile(path("a.ply"));
  EXPECT_TRUE(spinUntil(
      [&] {
        session.update(node);
        return !session.problem().empty();
      },
      TIMEOUT));
  EXPECT_NE(session.problem().find("mesh_msgs_hdf5"), std::string::npos);
  EXPECT_EQ(session.server(), nullptr);

  // What cannot be executed is a process that has ended.
  rviz_mesh_plugin::MapSession broken([] { return std::string("/dev/null"); });
  broken.setFile(path("a.ply"));
  EXPECT_TRUE(spinUntil(
      [&] {
        broken.update(node);
        return broken.server() && broken.server()->process().ended();
      },
      TIMEOUT));
  EXPECT_NE(broken.server()->ending().find("cannot be started"), std::string::npos)
      << broken.server()->ending();
}

TEST_F(Map3DServer, waits_for_no_share_that_does_not_answer)
{
  std::promise<void> gate;
  const auto opened = gate.get_future().share();
  write("b.ply", strip(3));
  auto session = std::make_unique<rviz_mesh_plugin::MapSession>(
      rviz_mesh_plugin::findMapServer, [opened](const std::string& file) {
        if (file.find("/share/") != std::string::npos) {
          opened.wait();
        }
        return rviz_mesh_plugin::lookAtFile(file);
      });
  session->setFile(path("share/a.ply"));
  const auto problemIs = [&](const std::string& words) {
    session->update(node);
    return session->lookProblem().find(words) != std::string::npos;
  };
  EXPECT_TRUE(spinUntil([&] { return problemIs("share/a.ply takes long"); }, TIMEOUT));
  EXPECT_EQ(session->server(), nullptr);
  session->setFile(path("b.ply"));
  EXPECT_TRUE(spinUntil(
      [&] {
        session->update(node);
        return session->server() &&
               session->server()->progress().stage == rviz_mesh_plugin::MapProgress::Stage::READY;
      },
      TIMEOUT));
  EXPECT_EQ(session->lookProblem(), "");
  session->setFile(path("share/a.ply"));
  session->update(node);
  session.reset();
  gate.set_value();
}
