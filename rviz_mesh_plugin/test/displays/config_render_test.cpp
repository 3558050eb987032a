#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <QComboBox>
#include <QStyleOptionViewItem>

#include <gtest/gtest.h>
#include <rviz/config.h>
#include <rviz/display_group.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/ros_topic_property.h>
#include <rviz/visualization_manager.h>
#include <rviz/yaml_config_reader.h>

#include "support/display_fixture.h"

namespace {

constexpr float INF = std::numeric_limits<float>::infinity();

struct Row
{
  std::vector<const char*> path;
  QVariant default_value;
  QVariant other_value;  ///< for the round trip
};

/// The file-format contract with the released plugin.
const std::vector<Row>& table()
{
  static const std::vector<Row> rows{
      {{"Geometry Topic"}, "", "/some/mesh"},
      {{"Buffer Size"}, 1, 3},
      {{"Display Type"}, "Fixed Color", "Vertex Costs"},
      {{"Display Type", "Faces Color"}, "0; 255; 0", "1; 2; 3"},
      {{"Display Type", "Faces Alpha"}, 1.0f, 0.25f},
      {{"Display Type", "Vertex Colors Topic"}, "", "/some/colors"},
      {{"Display Type", "Vertex Color Service Name"}, "get_vertex_colors", "/x/colors"},
      {{"Display Type", "Show textured faces only"}, false, true},
      {{"Display Type", "Material Service Name"}, "get_materials", "/x/materials"},
      {{"Display Type", "Texture Service Name"}, "get_texture", "/x/texture"},
      {{"Display Type", "Color Scale"}, "Rainbow", "Red Green"},
      {{"Display Type", "Vertex Costs Topic"}, "", "/some/costs"},
      {{"Display Type", "Vertex Costs Type"}, "-- None --", "Potential"},
      {{"Display Type", "Use Custom limits"}, false, true},
      {{"Display Type", "Use Custom limits", "Vertex Costs Lower Limit"}, 0.0f, -2.5f},
      {{"Display Type", "Use Custom limits", "Vertex Costs Upper Limit"}, 1.0f, 7.5f},
      {{"Show Wireframe"}, true, false},
      {{"Show Wireframe", "Wireframe Color"}, "0; 0; 0", "4; 5; 6"},
      {{"Show Wireframe", "Wireframe Alpha"}, 1.0f, 0.125f},
      {{"Show Normals"}, true, false},
      {{"Show Normals", "Normals Color"}, "255; 0; 255", "7; 8; 9"},
      {{"Show Normals", "Normals Alpha"}, 1.0f, 0.5f},
      {{"Show Normals", "Normals Scaling Factor"}, 0.1f, 0.75f},
  };
  return rows;
}

/// Properties that the released plugin does not have.
const std::vector<Row>& ownTable()
{
  static const std::vector<Row> rows{
      {{"Display Type", "Materials Topic"}, "", "/some/materials"},
      {{"Display Type", "Textures Topic"}, "", "/some/textures"},
      {{"Display Type", "Visualization Update Rate"}, 10.0f, 2.5f},
      {{"Display Type", "Alpha"}, 1.0f, 0.5f},
      {{"Culling Mode (HW)"}, "None", "Anticlockwise"},
      {{"Shading"}, "Smooth", "Flat"},
      {{"Level of Detail"}, true, false},
      {{"Level of Detail", "Detail in pixels"}, 4.0f, 5.0f},
      {{"Section"}, false, true},
      {{"Section", "Min Height"}, -INF, -2.5f},
      {{"Section", "Max Height"}, INF, 3.5f},
      {{"Section", "Min X"}, -INF, -10.0f},
      {{"Section", "Max X"}, INF, 20.0f},
      {{"Section", "Min Y"}, -INF, -0.5f},
      {{"Section", "Max Y"}, INF, 1.0f},
      {{"Show Labels"}, false, true},
      {{"Show Labels", "Labels Topic"}, "", "/some/labels"},
      {{"Show Labels", "Labels Alpha"}, 1.0f, 0.25f},
  };
  return rows;
}

std::vector<Row> allRows()
{
  std::vector<Row> rows = table();
  rows.insert(rows.end(), ownTable().begin(), ownTable().end());
  return rows;
}

std::string name(const Row& row)
{
  std::string joined;
  for (const char* part : row.path) {
    joined += std::string("/") + part;
  }
  return joined;
}

/// As mesh_navigation's stone quarry and farmer's pit have it, written by the
/// released plugin (with keys that are not ours, one of them the older "Mesh
/// Buffer Size").
const char* const RELEASED_FILE = R"(
Displays:
  - Class: rviz_map_plugin/Mesh
    Display Type:
      Color Scale: Red Green
      Faces Alpha: 0.1
      Faces Color: 0; 0; 0
      Material Service Name: get_materials
      Show textured faces only: false
      Texture Service Name: get_texture
      Use Custom limits:
        Value: true
        Vertex Costs Lower Limit: 0
        Vertex Costs Upper Limit: 0.12
      Value: Vertex Costs
      Vertex Color Service Name: get_vertex_colors
      Vertex Colors Topic: /move_base_flex/mesh_map/vertex_colors
      Vertex Costs Topic: /move_base_flex/mesh_map/vertex_costs
      Vertex Costs Type: Combined Costs
    Enabled: true
    Geometry Topic: /move_base_flex/mesh_map/mesh
    Mesh Buffer Size: 2
    Name: TexturedMesh
    Show Normals:
      Normals Alpha: 0.5
      Normals Color: 255; 0; 255
      Normals Scaling Factor: 0.3
      Value: false
    Show Wireframe:
      Value: true
      Wireframe Alpha: 0.2
      Wireframe Color: 238; 238; 236
    Value: true
)";

}  // namespace

class ConfigTest : public DisplayFixture
{
};

TEST_F(ConfigTest,
       from_a_file_both_class_names_give_the_same_display_with_the_properties_of_the_released_one)
{
  for (const char* class_id : {"rviz_mesh_plugin/TexturedMesh", "rviz_map_plugin/Mesh"}) {
    auto* display = createDisplayAs<Display>(class_id);
    EXPECT_EQ(display->getClassId().toStdString(), class_id);
    display->load(rviz::Config());  // a file that says nothing of any of them
    for (const Row& row : allRows()) {
      rviz::Property* property = find(display, row.path);
      EXPECT_EQ(property->getNameStd(), row.path.back());
      EXPECT_EQ(property->getValue().toString(), row.default_value.toString()) << name(row);
    }
  }
}

TEST_F(ConfigTest, properties_are_of_the_released_types_and_limits)
{
  auto* display = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh");
  const std::map<std::vector<const char*>, QString> topics{
      {{"Geometry Topic"}, "mesh_msgs/MeshGeometryStamped"},
      {{"Display Type", "Vertex Colors Topic"}, "mesh_msgs/MeshVertexColorsStamped"},
      {{"Display Type", "Vertex Costs Topic"}, "mesh_msgs/MeshVertexCostsStamped"},
      {{"Display Type", "Face Costs Topic"}, "mesh_msgs/MeshFaceCostsStamped"},
      {{"Display Type", "Update Topic"}, "mesh_msgs/MeshVertexCostsSparseStamped"},
      {{"Display Type", "Materials Topic"}, "mesh_msgs/MeshMaterialsStamped"},
      {{"Display Type", "Textures Topic"}, "mesh_msgs/MeshTexture"},
      {{"Show Labels", "Labels Topic"}, "mesh_msgs/MeshFaceCluster"},
  };
  for (const auto& [path, type] : topics) {
    auto* topic = dynamic_cast<rviz::RosTopicProperty*>(find(display, path));
    ASSERT_TRUE(topic) << path.back();
    EXPECT_EQ(topic->getMessageType(), type) << path.back();
  }
  for (const std::vector<const char*>& path :
       {std::vector<const char*>{"Display Type", "Faces Alpha"},
        {"Show Wireframe", "Wireframe Alpha"},
        {"Show Normals", "Normals Alpha"}}) {
    rviz::Property* alpha = find(display, path);
    alpha->setValue(-0.5f);
    EXPECT_EQ(alpha->getValue().toFloat(), 0.0f) << path.back();
    alpha->setValue(1.5f);
    EXPECT_EQ(alpha->getValue().toFloat(), 1.0f) << path.back();
  }
  display->subProp("Buffer Size")->setValue(0);
  EXPECT_EQ(display->subProp("Buffer Size")->getValue().toInt(), 1);
  const std::vector<std::pair<const char*, int>> types{
      {"Fixed Color", 0}, {"Vertex Color", 1}, {"Textures", 2},      {"Vertex Costs", 3},
      {"Hide Faces", 4},  {"Height", 5},       {"Contour Lines", 6}, {"Automatic", 7}};
  auto* type = dynamic_cast<rviz::EnumProperty*>(display->subProp("Display Type"));
  ASSERT_TRUE(type);
  for (const auto& [text, number] : types) {
    type->setValue(text);
    EXPECT_EQ(type->getOptionInt(), number) << text;
  }
}

TEST_F(ConfigTest, every_property_survives_saving_and_loading)
{
  auto* saved = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh", "saved", false);
  for (const Row& row : allRows()) {
    ASSERT_NE(row.default_value, row.other_value);
    set(saved, row.path, row.other_value);
  }
  rviz::Config config;
  saved->save(config);
  auto* loaded = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh", "loaded", false);
  loaded->load(config);
  for (const Row& row : allRows()) {
    EXPECT_EQ(find(loaded, row.path)->getValue().toString(), row.other_value.toString())
        << name(row);
  }
  EXPECT_EQ(loaded->getNameStd(), "saved");
}

TEST_F(ConfigTest, a_file_written_against_the_released_plugin_shows_the_same_choice)
{
  rviz::Config config;
  rviz::YamlConfigReader reader;
  reader.readString(config, RELEASED_FILE);
  ASSERT_FALSE(reader.error()) << reader.errorMessage().toStdString();
  rviz::DisplayGroup* root = manager()->getRootDisplayGroup();
  root->load(config);
  ASSERT_EQ(root->numDisplays(), 1);
  auto* display = dynamic_cast<Display*>(root->getDisplayAt(0));
  ASSERT_TRUE(display) << "rviz_map_plugin/Mesh did not become our display";
  EXPECT_TRUE(display->isEnabled());
  const std::map<std::string, std::string> expected{
      {"/Geometry Topic", "/move_base_flex/mesh_map/mesh"},
      {"/Buffer Size", "2"},
      {"/Display Type", "Vertex Costs"},
      {"/Display Type/Vertex Color Service Name", "get_vertex_colors"},
      {"/Display Type/Show textured faces only", "false"},
      {"/Display Type/Material Service Name", "get_materials"},
      {"/Display Type/Texture Service Name", "get_texture"},
      {"/Display Type/Faces Color", "0; 0; 0"},
      {"/Display Type/Faces Alpha", "0.1"},
      {"/Display Type/Vertex Colors Topic", "/move_base_flex/mesh_map/vertex_colors"},
      {"/Display Type/Color Scale", "Red Green"},
      {"/Display Type/Vertex Costs Topic", "/move_base_flex/mesh_map/vertex_costs"},
      {"/Display Type/Vertex Costs Type", "Combined Costs"},
      {"/Display Type/Use Custom limits", "true"},
      {"/Display Type/Use Custom limits/Vertex Costs Lower Limit", "0"},
      {"/Display Type/Use Custom limits/Vertex Costs Upper Limit", "0.12"},
      {"/Show Wireframe", "true"},
      {"/Show Wireframe/Wireframe Color", "238; 238; 236"},
      {"/Show Wireframe/Wireframe Alpha", "0.2"},
      {"/Show Normals", "false"},
      {"/Show Normals/Normals Color", "255; 0; 255"},
      {"/Show Normals/Normals Alpha", "0.5"},
      {"/Show Normals/Normals Scaling Factor", "0.3"},
  };
  ASSERT_EQ(expected.size(), table().size());
  for (const Row& row : table()) {
    const QString value = find(display, row.path)->getValue().toString();
    const QString other = QString::fromStdString(expected.at(name(row)));
    bool number = false;
    if (const float limit = other.toFloat(&number); number) {
      EXPECT_EQ(value.toFloat(), limit) << name(row);
    } else {
      EXPECT_EQ(value, other) << name(row);
    }
  }
}

TEST_F(ConfigTest, a_costs_type_from_a_file_waits_for_its_layer)
{
  auto* display = createMeshDisplay();
  set(display, {"Display Type"}, "Vertex Costs");
  set(display, {"Display Type", "Vertex Costs Type"}, "Potential");
  ASSERT_TRUE(show(display, test_meshes::square()));
  costs.publish(test_meshes::costs("height_diff", {0, 0, 0, 1}));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Warn",
                            "layer 'Potential' has not arrived; there are 'height_diff'"));
  EXPECT_EQ(find(display, {"Display Type", "Vertex Costs Type"})->getValue().toString(),
            "Potential");
  costs.publish(test_meshes::costs("Potential", {0, 1, 2, 3}));
  EXPECT_TRUE(waitForStatus(display, "Costs", "Ok", "'Potential': 4 costs from 0 to 3"));
}

TEST_F(ConfigTest, only_properties_of_the_chosen_display_type_are_seen)
{
  auto* display = createMeshDisplay();
  const std::map<std::string, std::vector<std::string>> seen{
      {"Fixed Color", {"Faces Color", "Faces Alpha"}},
      {"Vertex Color", {"Vertex Colors Topic", "Vertex Color Service Name", "Alpha"}},
      {"Textures",
       {"Faces Color", "Show textured faces only", "Material Service Name", "Texture Service Name",
        "Materials Topic", "Textures Topic", "Alpha"}},
      {"Hide Faces", {}},
  };
  rviz::Property* type = display->subProp("Display Type");
  for (const auto& choice : seen) {
    type->setValue(QString::fromStdString(choice.first));
    std::vector<std::string> names;
    for (int i = 0; i < type->numChildren(); ++i) {
      if (!type->childAt(i)->getHidden()) {
        names.push_back(type->childAt(i)->getNameStd());
      }
    }
    EXPECT_EQ(names, choice.second) << choice.first;
  }
}

TEST_F(ConfigTest, is_offered_for_mesh_topics)
{
  auto* display = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh");
  display->setTopic("/some/mesh", "mesh_msgs/MeshGeometryStamped");
  EXPECT_EQ(display->subProp("Geometry Topic")->getValue().toString(), "/some/mesh");
}

TEST_F(ConfigTest, adding_by_topic_finds_the_costs_and_colors_beside_the_mesh)
{
  auto* display = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh");
  display->setTopic(geometry_topic.c_str(), "mesh_msgs/MeshGeometryStamped");
  // The master is asked on a thread of its own.
  EXPECT_TRUE(spinUntil([&] {
    return find(display, {"Display Type", "Vertex Costs Topic"})->getValue().toString() ==
           costs_topic.c_str();
  }));
  EXPECT_EQ(find(display, {"Display Type", "Vertex Colors Topic"})->getValue().toString(),
            colors_topic.c_str());
  set(display, {"Display Type", "Vertex Costs Topic"}, "/chosen");
  set(display, {"Display Type", "Vertex Colors Topic"}, "");
  display->setTopic(geometry_topic.c_str(), "mesh_msgs/MeshGeometryStamped");
  EXPECT_TRUE(spinUntil([&] {
    return find(display, {"Display Type", "Vertex Colors Topic"})->getValue().toString() ==
           colors_topic.c_str();
  }));
  EXPECT_EQ(find(display, {"Display Type", "Vertex Costs Topic"})->getValue().toString(),
            "/chosen");
}

TEST_F(ConfigTest, within_another_display_types_are_offered_with_their_data_and_a_choice_stays)
{
  auto* display = createDisplayAs<Display>("rviz_mesh_plugin/TexturedMesh");
  set(display, {"Display Type"}, "Textures");
  rviz_mesh_plugin::MeshSource source;
  source.geometry_topic = geometry_topic;
  source.costs_topic = costs_topic;
  source.colors_topic = colors_topic;
  source.service_namespace = "/nobody";
  display->setSource(source);
  for (const char* hidden : {"Geometry Topic", "Buffer Size"}) {
    EXPECT_TRUE(find(display, {hidden})->getHidden()) << hidden;
  }
  auto* type = dynamic_cast<rviz::EnumProperty*>(display->subProp("Display Type"));
  const auto offered = [&] {
    std::vector<std::string> names;
    QStyleOptionViewItem option;
    const std::unique_ptr<QWidget> editor(type->createEditor(nullptr, option));
    const auto* box = dynamic_cast<QComboBox*>(editor.get());
    for (int i = 0; box && i < box->count(); ++i) {
      names.push_back(box->itemText(i).toStdString());
    }
    return names;
  };
  EXPECT_EQ(offered(), (std::vector<std::string>{"Automatic", "Fixed Color", "Textures", "Height",
                                                 "Contour Lines", "Hide Faces"}));
  ASSERT_TRUE(show(display, test_meshes::square()));
  costs.publish(test_meshes::costs("a", {0, 0, 0, 1}));
  ASSERT_TRUE(waitForStatus(display, "Costs", "Ok", "'a'"));
  EXPECT_EQ(offered(),
            (std::vector<std::string>{"Automatic", "Fixed Color", "Textures", "Vertex Costs",
                                      "Height", "Contour Lines", "Hide Faces"}));
  EXPECT_EQ(type->getString(), "Textures") << "is kept and waits for its data";
  set(display, {"Display Type"}, "Vertex Costs");
  EXPECT_TRUE(find(display, {"Display Type", "Vertex Costs Topic"})->getHidden());
  EXPECT_FALSE(find(display, {"Display Type", "Vertex Costs Type"})->getHidden());
}
