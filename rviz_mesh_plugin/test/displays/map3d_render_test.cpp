// Map3D, its children and its configuration.
#include <rviz/config.h>

#include "displays/cluster_label_display.h"
#include "support/map3d_fixture.h"

namespace {

class Map3D : public Map3DFixture
{
};

rviz::Property* child(rviz::Property* property, const std::vector<const char*>& path)
{
  for (const char* name : path) {
    property = property->subProp(name);
  }
  return property;
}

}  // namespace

TEST_F(Map3D, says_what_to_do_as_long_as_no_file_is_chosen)
{
  for (const char* class_id : {"rviz_mesh_plugin/Map3D", "rviz_map_plugin/Map3D"}) {
    Display* display = createMap("", "Map", class_id);
    EXPECT_TRUE(waitForStatus(display, "Map", "Warn", "No map file path specified!"));
    EXPECT_EQ(display->subProp("Map file path")->getValue().toString(), "/path/to/map.h5");
    ASSERT_EQ(display->numDisplays(), 2);
    EXPECT_EQ(display->getDisplayAt(0)->getName(), "ClusterLabel");
    EXPECT_EQ(display->getDisplayAt(1)->getName(), "Mesh");
    EXPECT_FALSE(display->getViewFlags(0) & Qt::ItemIsDropEnabled);
    EXPECT_TRUE(children().empty());
    remove(display);
  }
}

TEST_F(Map3D, is_loaded_from_files_of_the_released_plugin)
{
  rviz::Config config;
  config.mapSetValue("Class", "rviz_map_plugin/Map3D");
  config.mapSetValue("Name", "Old");
  config.mapSetValue("Enabled", true);
  config.mapSetValue("Value", true);
  config.mapSetValue("Map file path", "/nowhere/map.h5");
  rviz::Config labels = config.mapMakeChild("ClusterLabel");
  labels.mapSetValue("Enabled", false);
  labels.mapSetValue("Value", false);
  labels.mapSetValue("Transparency", 0.5);
  rviz::Config mesh = config.mapMakeChild("Mesh");
  mesh.mapSetValue("Enabled", true);
  mesh.mapSetValue("Value", true);
  rviz::Config type = mesh.mapMakeChild("Display Type");
  type.mapSetValue("Value", "Vertex Costs");
  type.mapSetValue("Vertex Costs Type", "height_diff");

  Display* display = createMap();
  display->load(config);
  const auto check = [](Display* loaded) {
    EXPECT_EQ(loaded->getName(), "Old");
    EXPECT_EQ(loaded->subProp("Map file path")->getValue().toString(), "/nowhere/map.h5");
    ASSERT_NE(loaded->labelDisplay(), nullptr);
    EXPECT_FALSE(loaded->labelDisplay()->isEnabled());
    EXPECT_EQ(loaded->labelDisplay()->subProp("Transparency")->getValue().toFloat(), 0.5f);
    ASSERT_NE(loaded->meshDisplay(), nullptr);
    EXPECT_TRUE(loaded->meshDisplay()->isEnabled());
    rviz::Property* chosen = loaded->meshDisplay()->subProp("Display Type");
    EXPECT_EQ(chosen->getValue().toString(), "Vertex Costs");
    EXPECT_EQ(child(chosen, {"Vertex Costs Type"})->getValue().toString(), "height_diff");
    EXPECT_EQ(loaded->numDisplays(), 2);
  };
  check(display);
  EXPECT_TRUE(waitForStatus(display, "Map", "Error", "Specified map file does not exist!"));

  display->subProp("Frame")->setValue("odom");
  rviz::Config saved;
  display->save(saved);
  EXPECT_EQ(saved.mapGetChild("Displays").listLength(), 0);
  Display* again = createMap();
  again->load(saved);
  check(again);
  EXPECT_EQ(again->subProp("Frame")->getValue().toString(), "odom");
}

TEST_F(Map3D, can_be_told_its_file_by_a_parameter)
{
  node.setParam(ros::this_node::getName() + "/rviz_map_plugin/Mine", path("other.h5"));
  Display* display = createMap("", "Mine");
  rviz::Config config;
  config.mapSetValue("Name", "Mine");
  config.mapSetValue("Enabled", true);
  config.mapSetValue("Map file path", "/nowhere/map.h5");
  display->load(config);
  EXPECT_EQ(display->subProp("Map file path")->getValue().toString().toStdString(),
            path("other.h5"));
  EXPECT_TRUE(waitForStatus(display, "Map", "Error", path("other.h5")));
  config.mapSetValue("Name", "No name for a parameter!");
  display->load(config);
  EXPECT_EQ(display->subProp("Map file path")->getValue().toString(), "/nowhere/map.h5");
}

TEST_F(Map3D, survives_the_removal_of_its_children)
{
  Display* display = createMap(path("late.ply"));
  remove(display->meshDisplay());
  spinFrames();
  EXPECT_EQ(display->meshDisplay(), nullptr);
  remove(display->labelDisplay());
  spinFrames();
  display->reset();
  rviz::Config saved;
  display->save(saved);
  display->load(saved);  // that makes new ones
  EXPECT_EQ(display->numDisplays(), 2);
  write("late.ply", strip(2));
  EXPECT_TRUE(waitForStatus(display, "Map", "Ok", "6 vertices, 4 faces"));
  EXPECT_TRUE(waitForFaces(display, 4));
}

TEST_F(Map3D, that_is_collapsed_is_as_red_as_its_children)
{
  write("map.ply", strip(2));
  auto* display = createMap(path("map.ply"));
  ASSERT_TRUE(waitForFaces(display, 4));
  const auto level = [&] {
    for (int i = 0; i < display->numChildren(); ++i) {
      if (const auto* lines = dynamic_cast<rviz::StatusList*>(display->childAt(i))) {
        return lines->getLevel();
      }
    }
    return rviz::StatusProperty::Ok;
  };
  ASSERT_TRUE(spinUntil([&] { return level() == rviz::StatusProperty::Ok; }, TIMEOUT))
      << status(display, "Parts");
  EXPECT_EQ(status(display, "Parts"), "");
  display->meshDisplay()->setStatus(rviz::StatusProperty::Warn, "One", "not so good");
  EXPECT_TRUE(waitForStatus(display, "Parts", "Warn", "Mesh, One: not so good"));
  display->labelDisplay()->setStatus(rviz::StatusProperty::Error, "Two", "broken");
  EXPECT_TRUE(waitForStatus(display, "Parts", "Error",
                            "ClusterLabel, Two: broken (and 1 line more below)"));
  EXPECT_EQ(level(), rviz::StatusProperty::Error);
  display->labelDisplay()->setEnabled(false);
  EXPECT_TRUE(waitForStatus(display, "Parts", "Warn", "Mesh, One: not so good")) << "it is hidden";
  display->meshDisplay()->deleteStatus("One");
  EXPECT_TRUE(spinUntil([&] { return status(display, "Parts").empty(); }, TIMEOUT));
}

TEST_F(Map3D, shows_a_mesh_in_the_frame_that_is_asked_for)
{
  write("a.ply", strip(3));
  Display* display = createMap(path("a.ply"));
  EXPECT_TRUE(waitForFaces(display, 6));
  viewFromAbove(1.5, 0.5, 100.0);
  rviz::Property* mesh = display->meshDisplay();
  mesh->subProp("Show Wireframe")->setValue(false);
  mesh->subProp("Show Normals")->setValue(false);
  const osmesa_harness::Rgb green{0, 255, 0};
  EXPECT_TRUE(spinUntil([&] { return grab().center() == green; }, TIMEOUT));
  const osmesa_harness::Image image = grab();
  EXPECT_TRUE(osmesa_harness::sameOnAllBackEnds("map3d", image));
  display->subProp("Frame")->setValue("nowhere");
  EXPECT_TRUE(spinUntil([&] { return !(grab().center() == green); }, TIMEOUT));
  EXPECT_TRUE(waitForStatus(display->meshDisplay(), "Transform", "Error", "nowhere"));
  display->subProp("Frame")->setValue("<Fixed Frame>");
  EXPECT_TRUE(spinUntil([&] { return grab().center() == green; }, TIMEOUT));
  display->setEnabled(false);
  EXPECT_TRUE(spinUntil([&] { return !(grab().center() == green); }, TIMEOUT));
  const pid_t server = serverOf(display);
  EXPECT_GT(server, 0);  // it goes on, so that showing the map again is quick
  display->setEnabled(true);
  EXPECT_TRUE(spinUntil([&] { return grab().center() == green; }, TIMEOUT));
  EXPECT_EQ(serverOf(display), server);
}

TEST_F(Map3D, leaves_nothing_in_the_scene)
{
  write("a.ply", strip(3));
  osmesa_harness::SceneCounts before;
  for (int i = 0; i < 2; ++i) {  // what is made once for all is there after the first
    before = counts();
    Display* display = createMap(path("a.ply"));
    ASSERT_TRUE(waitForFaces(display, 6));
    spinFrames(5);
    remove(display);
    spinFrames();
  }
  EXPECT_EQ(counts(), before);
}
