#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rviz/config.h>
#include <rviz/display_group.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/editable_enum_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/int_property.h>
#include <rviz/properties/status_list.h>
#include <rviz/visualization_manager.h>
#include <rviz/yaml_config_reader.h>
#include <rviz/yaml_config_writer.h>

#include "support/display_fixture.h"

namespace {

/// What differs between the six configurations in the field.
struct FieldFile
{
  const char* name;
  const char* display_type;
  const char* costs_type;
  const char* custom_limits;
  const char* lower_limit;
  const char* upper_limit;
  const char* faces_alpha;
  const char* faces_color;
  const char* wireframe_alpha;
  const char* wireframe_color;
};

constexpr FieldFile FIELD_FILES[] = {
    {"botanical garden", "Fixed Color", "height_diff", "true", "0", "0.4", "0.1", "0; 0; 0", "0.2",
     "0; 0; 0"},
    {"physics campus", "Fixed Color", "height_diff", "true", "0", "0.4", "0.1", "0; 0; 0", "0.2",
     "0; 0; 0"},
    {"farmer's pit", "Vertex Costs", "Potential", "false", "0", "1", "1", "0; 255; 0", "1",
     "0; 0; 0"},
    {"market garden, all", "Vertex Costs", "Combined Costs", "true", "0", "0.12", "0.1", "0; 0; 0",
     "0.2", "0; 0; 0"},
    {"market garden, inner", "Vertex Costs", "Combined Costs", "true", "0", "0.12", "0.1",
     "0; 0; 0", "0.2", "0; 0; 0"},
    {"stone quarry", "Vertex Costs", "Combined Costs", "false", "20", "80", "0", "0; 255; 0", "0.2",
     "238; 238; 236"},
};

/// The display as the released plugin writes it, all keys.
std::string fieldConfig(const FieldFile& file)
{
  const auto line = [](int indent, const std::string& key, const std::string& value) {
    return std::string(static_cast<std::size_t>(indent), ' ') + key + ": " + value + "\n";
  };
  const std::string server = "/move_base_flex/mesh_map/";
  return "Displays:\n  - Class: rviz_map_plugin/Mesh\n    Display Type:\n" +
         line(6, "Color Scale", "Rainbow") + line(6, "Faces Alpha", file.faces_alpha) +
         line(6, "Faces Color", file.faces_color) +
         line(6, "Material Service Name", "get_materials") +
         line(6, "Show textured faces only", "false") +
         line(6, "Texture Service Name", "get_texture") + "      Use Custom limits:\n" +
         line(8, "Value", file.custom_limits) +
         line(8, "Vertex Costs Lower Limit", file.lower_limit) +
         line(8, "Vertex Costs Upper Limit", file.upper_limit) +
         line(6, "Value", file.display_type) +
         line(6, "Vertex Color Service Name", "get_vertex_colors") +
         line(6, "Vertex Colors Topic", server + "vertex_colors") +
         line(6, "Vertex Costs Topic", server + "vertex_costs") +
         line(6, "Vertex Costs Type", file.costs_type) + line(4, "Enabled", "false") +
         line(4, "Geometry Topic", server + "mesh") + line(4, "Mesh Buffer Size", "1") +
         line(4, "Name", "TexturedMesh") + "    Show Normals:\n" + line(6, "Normals Alpha", "0.5") +
         line(6, "Normals Color", "255; 0; 255") + line(6, "Normals Scaling Factor", "0.3") +
         line(6, "Value", "false") + "    Show Wireframe:\n" + line(6, "Value", "true") +
         line(6, "Wireframe Alpha", file.wireframe_alpha) +
         line(6, "Wireframe Color", file.wireframe_color) + line(4, "Value", "false");
}

rviz::Config parse(const QString& text)
{
  rviz::Config config;
  rviz::YamlConfigReader reader;
  reader.readString(config, text);
  EXPECT_FALSE(reader.error()) << reader.errorMessage().toStdString();
  return config;
}

QString save(const rviz::Display* display)
{
  rviz::Config config;
  display->save(config);
  return rviz::YamlConfigWriter().writeString(config);
}

/// Each value of a tree of keys must be in the other one, too.
void expectWithin(const rviz::Config& part, const rviz::Config& whole, const std::string& path)
{
  if (part.getType() == rviz::Config::Value) {
    bool number = false;
    const float value = part.getValue().toString().toFloat(&number);
    if (number) {
      EXPECT_EQ(whole.getValue().toFloat(), value) << path;
    } else {
      EXPECT_EQ(whole.getValue().toString().toStdString(), part.getValue().toString().toStdString())
          << path;
    }
    return;
  }
  for (auto i = part.mapIterator(); i.isValid(); i.advance()) {
    const QString key = i.currentKey();
    // The older name of the released one.
    const QString ours = key == "Mesh Buffer Size" ? "Buffer Size" : key;
    expectWithin(i.currentChild(), whole.mapGetChild(ours), path + "/" + key.toStdString());
  }
}

/// All properties that are saved, by their way from the display.
void collect(rviz::Property* parent, const std::string& path,
             std::vector<std::pair<std::string, rviz::Property*>>& found)
{
  for (int i = 0; i < parent->numChildren(); ++i) {
    rviz::Property* child = parent->childAt(i);
    if (dynamic_cast<rviz::StatusProperty*>(child) || dynamic_cast<rviz::Display*>(child)) {
      continue;
    }
    const std::string name = path + "/" + child->getNameStd();
    if (child->shouldBeSaved() && child->getValue().isValid()) {
      found.emplace_back(name, child);
    }
    collect(child, name, found);
  }
}

/// Gives a property another value that it accepts; the choices of enumerations are asked for.
bool change(rviz::Property* property)
{
  const QVariant before = property->getValue();
  std::vector<QVariant> candidates;
  if (dynamic_cast<rviz::BoolProperty*>(property)) {
    candidates = {!before.toBool()};
  } else if (dynamic_cast<rviz::ColorProperty*>(property)) {
    candidates = {QColor(12, 34, 56)};
  } else if (auto* integer = dynamic_cast<rviz::IntProperty*>(property)) {
    candidates = {before.toInt() + 1, integer->getMin(), integer->getMax()};
  } else if (auto* number = dynamic_cast<rviz::FloatProperty*>(property)) {
    candidates = {before.toFloat() + 0.125f, before.toFloat() - 0.125f, number->getMin(), 0.5f};
  } else {
    for (const char* text : {"Vertex Costs", "Viridis", "Red Green", "Clockwise", "Flat", "Back",
                             "/some/name", "some_name"}) {
      candidates.emplace_back(QString(text));
    }
  }
  for (const QVariant& candidate : candidates) {
    auto* choice = dynamic_cast<rviz::EnumProperty*>(property);
    const int option = choice ? choice->getOptionInt() : 0;
    property->setValue(candidate);
    // RViz takes any text, also one that is no option: its number is 0 then.
    const bool accepted = !choice || choice->getOptionInt() != option;
    if (accepted && property->getValue() != before) {
      return true;
    }
    property->setValue(before);
  }
  return false;
}

}  // namespace

class FieldConfigTest : public DisplayFixture
{
};

TEST_F(FieldConfigTest, all_six_configurations_in_the_field_keep_their_choices)
{
  for (const FieldFile& file : FIELD_FILES) {
    SCOPED_TRACE(file.name);
    const rviz::Config config = parse(QString::fromStdString(fieldConfig(file)));
    rviz::DisplayGroup* root = manager()->getRootDisplayGroup();
    root->load(config);
    ASSERT_EQ(root->numDisplays(), 1);
    auto* display = dynamic_cast<Display*>(root->getDisplayAt(0));
    ASSERT_TRUE(display);
    expectWithin(config.mapGetChild("Displays").listChildAt(0), parse(save(display)), "");
    EXPECT_EQ(display->subProp("Display Type")->getValue().toString(), file.display_type);
  }
}

TEST_F(FieldConfigTest, what_is_saved_and_loaded_is_saved_identically)
{
  const std::vector<std::string> classes{
      "rviz_mesh_plugin/TexturedMesh", "rviz_map_plugin/Mesh",   "rviz_mesh_plugin/ClusterLabel",
      "rviz_map_plugin/ClusterLabel",  "rviz_mesh_plugin/Map3D", "rviz_map_plugin/Map3D"};
  for (const std::string& class_id : classes) {
    SCOPED_TRACE(class_id);
    rviz::Display* first = createDisplay(class_id, "first", false);
    const QString defaults = save(first);
    std::vector<std::pair<std::string, rviz::Property*>> properties;
    collect(first, "", properties);
    EXPECT_GE(properties.size(), 2u);
    for (const auto& property : properties) {
      // Choices that are made of data have none yet.
      EXPECT_TRUE(change(property.second) || dynamic_cast<rviz::EnumProperty*>(property.second))
          << property.first << " could not be changed";
    }
    const QString changed = save(first);
    EXPECT_NE(changed, defaults);
    rviz::Display* second = createDisplay(class_id, "second", false);
    second->load(parse(changed));
    EXPECT_EQ(save(second).toStdString(), changed.toStdString());
    // What is not in a file has its default, whatever it is that a new display begins with.
    rviz::Display* third = createDisplay(class_id, "third", false);
    third->load(parse("Name: first"));
    const QString of_file = save(third);
    EXPECT_EQ(of_file.contains("Color Scale: Viridis"), false);
    if (class_id.find("rviz_map_plugin") == 0 ||
        class_id.find("ClusterLabel") != std::string::npos) {
      EXPECT_EQ(of_file.toStdString(), defaults.toStdString());
    }
  }
}
