#pragma once

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <dirent.h>
#include <gtest/gtest.h>
#include <ros/node_handle.h>
#include <rviz/properties/property.h>
#include <rviz/visualization_manager.h>
#include <sys/stat.h>
#include <unistd.h>

#include "displays/map3d_display.h"
#include "displays/textured_mesh_display.h"
#include "status_fixture.h"

/// Map3D displays, and files for them in a folder of the test's own.
class Map3DFixture : public StatusFixture
{
 protected:
  using Display = rviz_mesh_plugin::Map3DDisplay;

  void SetUp() override
  {
    StatusFixture::SetUp();
    char pattern[] = "/tmp/map3d_test_XXXXXX";
    ASSERT_NE(::mkdtemp(pattern), nullptr);
    folder = pattern;
  }

  void TearDown() override
  {
    StatusFixture::TearDown();
    EXPECT_TRUE(spinUntil([] { return children().empty(); }, TIMEOUT)) << "a process was left";
    EXPECT_EQ(std::system(("rm -r '" + folder + "'").c_str()), 0);
  }

  /// The processes that this one has started, but for those that have ended.
  static std::vector<pid_t> children()
  {
    std::vector<pid_t> found;
    DIR* processes = ::opendir("/proc");
    for (dirent* entry = processes ? ::readdir(processes) : nullptr; entry;
         entry = ::readdir(processes)) {
      std::ifstream file("/proc/" + std::string(entry->d_name) + "/stat");
      std::string text;
      std::getline(file, text);
      const std::size_t end = text.rfind(')');  // of the name, which may hold anything
      if (end != std::string::npos && std::atoi(text.c_str() + end + 3) == ::getpid()) {
        found.push_back(std::atoi(entry->d_name));
      }
    }
    if (processes) {
      ::closedir(processes);
    }
    return found;
  }

  std::string path(const std::string& name) const { return folder + "/" + name; }

  void write(const std::string& name, const std::string& text) const
  {
    std::ofstream(path(name) + ".new") << text;
    ASSERT_EQ(std::rename((path(name) + ".new").c_str(), path(name).c_str()), 0);
  }

  /// A flat strip of so many squares of 1 m, at z = 0.
  static std::string strip(int squares)
  {
    std::string vertices, faces;
    for (int i = 0; i <= squares; ++i) {
      vertices += std::to_string(i) + " 0 0\n" + std::to_string(i) + " 1 0\n";
    }
    for (int i = 0; i < squares; ++i) {
      const std::string a = std::to_string(2 * i), b = std::to_string(2 * i + 1);
      const std::string c = std::to_string(2 * i + 2), d = std::to_string(2 * i + 3);
      faces += "3 " + a + " " + c + " " + d + "\n3 " + a + " " + d + " " + b + "\n";
    }
    return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(2 * squares + 2) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
           std::to_string(2 * squares) + "\nproperty list uchar int vertex_indices\nend_header\n" +
           vertices + faces;
  }

  /// A map file of the same.
  void writeMap(const std::string& name, int squares) const
  {
    write("import.ply", strip(squares));
    const std::string server = rviz_mesh_plugin::findMapServer();
    const std::string tool = server.substr(0, server.rfind('/')) + "/mesh_tool";
    const std::string made = path("made.h5");
    ASSERT_EQ(std::system((tool + " import -q " + path("import.ply") + " " + made).c_str()), 0);
    ASSERT_EQ(std::rename(made.c_str(), path(name).c_str()), 0);
  }

  Display* createMap(const std::string& file = "", const std::string& name = "Map",
                     const std::string& class_id = "rviz_map_plugin/Map3D")
  {
    auto* display = createDisplayAs<Display>(class_id, name);
    if (!file.empty()) {
      choose(display, file);
    }
    return display;
  }

  static void choose(Display* display, const std::string& file)
  {
    display->subProp("Map file path")->setValue(QString::fromStdString(file));
  }

  /// Waits until the child Mesh has a mesh of so many faces.
  static testing::AssertionResult waitForFaces(const Display* display, std::size_t faces)
  {
    const auto shown = [&]() -> std::size_t {
      const auto* mesh = display->meshDisplay();
      return mesh && mesh->mesh() ? mesh->mesh()->faceCount() : 0;
    };
    if (spinUntil([&] { return shown() == faces; }, TIMEOUT)) {
      return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << "there are " << shown() << " faces";
  }

  static pid_t serverOf(const Display* display)
  {
    const auto* server = display->session().server();
    return server ? static_cast<pid_t>(server->process().processId()) : 0;
  }

  static void remove(rviz::Display* display) { delete display; }

  ros::NodeHandle node;
  std::string folder;
};
