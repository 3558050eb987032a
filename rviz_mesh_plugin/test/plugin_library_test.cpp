#include <array>
#include <cstdio>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <rviz/display.h>
#include <rviz/display_factory.h>
#include <rviz/panel.h>
#include <rviz/tool.h>
#include <QStringList>
#include <pluginlib/class_loader.hpp>

namespace {

/// Output of a command; its exit status is asserted to be 0.
std::string outputOf(const std::string& command)
{
  std::string output;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) {
    ADD_FAILURE() << command << " cannot be run";
    return output;
  }
  std::array<char, 4096> buffer{};
  while (fgets(buffer.data(), buffer.size(), pipe)) {
    output += buffer.data();
  }
  EXPECT_EQ(pclose(pipe), 0) << command << "\n" << output;
  return output;
}

}  // namespace

TEST(PluginLibrary, has_no_undefined_symbol_and_misses_no_library)
{
  for (const char* library : {PLUGIN_LIBRARY, CORE_LIBRARY}) {
    const std::string output = outputOf(std::string("ldd -r '") + library + "'");
    EXPECT_NE(output.find("librviz.so"), std::string::npos) << output;
    EXPECT_EQ(output.find("undefined symbol"), std::string::npos) << output;
    EXPECT_EQ(output.find("not found"), std::string::npos) << output;
  }
}

/// The released names are declared by the package rviz_map_plugin, which depends on this one.
template <class Base>
void expectNames(const char* base, const std::map<std::string, std::string>& types)
{
  pluginlib::ClassLoader<Base> loader("rviz", base);
  std::set<std::string> declared;
  for (const std::string& name : loader.getDeclaredClasses()) {
    if (loader.getClassType(name).find("rviz_mesh_plugin::") == 0) {
      declared.insert(name);
      // RViz's dialogs have a heading for each package.
      EXPECT_EQ(loader.getClassPackage(name), name.substr(0, name.find('/'))) << name;
    }
  }
  for (const auto& type : types) {
    ASSERT_EQ(declared.count(type.first), 1u) << type.first;
    EXPECT_EQ(loader.getClassType(type.first), "rviz_mesh_plugin::" + type.second);
    declared.erase(type.first);
  }
  for (const std::string& other : declared) {
    ADD_FAILURE() << other << " is declared, and not expected";
  }
}

TEST(PluginLibrary, is_declared_under_both_names_each_in_its_own_package)
{
  expectNames<rviz::Display>("rviz::Display",
                             {{"rviz_mesh_plugin/TexturedMesh", "TexturedMeshDisplay"},
                              {"rviz_map_plugin/Mesh", "TexturedMeshDisplay"},
                              {"rviz_mesh_plugin/ClusterLabel", "ClusterLabelDisplay"},
                              {"rviz_map_plugin/ClusterLabel", "ClusterLabelDisplay"},
                              {"rviz_mesh_plugin/Map3D", "Map3DDisplay"},
                              {"rviz_map_plugin/Map3D", "Map3DDisplay"}});
  expectNames<rviz::Tool>("rviz::Tool",
                          {{"rviz_mesh_plugin/ClusterLabel", "ClusterLabelTool"},
                           {"rviz_map_plugin/ClusterLabel", "ClusterLabelTool"},
                           {"rviz_mesh_plugin/MeshGoal", "MeshGoalTool"},
                           {"rviz_map_plugin/MeshGoal", "MeshGoalTool"},
                           {"rviz_mesh_plugin/MeshPoseEstimate", "MeshPoseEstimateTool"},
                           {"rviz_mesh_plugin/MeshInspect", "MeshInspectTool"},
                           {"rviz_mesh_plugin/MeshMeasure", "MeshMeasureTool"}});
  expectNames<rviz::Panel>("rviz::Panel",
                           {{"rviz_mesh_plugin/ClusterLabel", "ClusterLabelPanel"},
                            {"rviz_map_plugin/ClusterLabel", "ClusterLabelPanel"},
                            {"rviz_mesh_plugin/MeshNavigation", "MeshNavigationPanel"}});
}

TEST(PluginLibrary, offers_one_display_for_a_topic)
{
  rviz::DisplayFactory factory;
  std::map<QString, QStringList> displays;
  for (const QString& name : factory.getDeclaredClassIds()) {
    for (const QString& message : factory.getMessageTypes(name)) {
      displays[message].append(name);
    }
  }
  EXPECT_EQ(displays["mesh_msgs/MeshGeometryStamped"],
            QStringList("rviz_mesh_plugin/TexturedMesh"));
  EXPECT_EQ(displays["mesh_msgs/MeshFaceCluster"], QStringList("rviz_mesh_plugin/ClusterLabel"));
}
