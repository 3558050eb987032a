#include <array>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>
#include <rviz/display.h>
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

TEST(PluginLibrary, is_declared_under_both_names)
{
  pluginlib::ClassLoader<rviz::Display> loader("rviz", "rviz::Display");
  for (const char* name : {"rviz_mesh_plugin/TexturedMesh", "rviz_map_plugin/Mesh"}) {
    ASSERT_TRUE(loader.isClassAvailable(name)) << name;
    EXPECT_EQ(loader.getClassType(name), "rviz_mesh_plugin::TexturedMeshDisplay");
    EXPECT_EQ(loader.getClassPackage(name), "rviz_mesh_plugin");
  }
}
