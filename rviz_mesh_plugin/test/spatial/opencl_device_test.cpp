#include "spatial/opencl_device.h"

#include <gtest/gtest.h>

#include <cstdlib>

using rviz_mesh_plugin::chooseDevice;
using rviz_mesh_plugin::DeviceInfo;
using rviz_mesh_plugin::DeviceType;
using rviz_mesh_plugin::deviceWish;

namespace {

DeviceInfo device(DeviceType type, const std::string& name, const std::string& platform)
{
  DeviceInfo info;
  info.type = type;
  info.name = name;
  info.platform = platform;
  info.driver = "1.0";
  return info;
}

const std::vector<DeviceInfo> DEVICES = {
    device(DeviceType::OTHER, "Stratix", "FPGA SDK"),
    device(DeviceType::CPU, "pthread-EPYC", "Portable Computing Language"),
    device(DeviceType::GPU, "GeForce RTX", "NVIDIA CUDA"),
    device(DeviceType::CPU, "EPYC", "Intel(R) OpenCL"),
    device(DeviceType::GPU, "gfx1030", "AMD Accelerated"),
};

}  // namespace

TEST(OpenClDevice, takes_a_gpu_before_a_cpu_before_others_and_the_first_of_them)
{
  EXPECT_EQ(chooseDevice(DEVICES, ""), 2u);
  EXPECT_EQ(chooseDevice({DEVICES[0], DEVICES[1], DEVICES[3]}, ""), 1u);
  EXPECT_EQ(chooseDevice({DEVICES[0]}, ""), 0u);
  EXPECT_FALSE(chooseDevice({}, ""));
}

TEST(OpenClDevice, follows_a_wish)
{
  const std::pair<const char*, int> cases[] = {
      {"gpu", 2},  {"cpu", 1},     {"epyc", 1}, {"intel", 3},   {"portable", 1},
      {"gfx", 4},  {"stratix", 0}, {"cl", 3},   {"opencl", 3},  {"nvidia cuda", 2},
      {"off", -1}, {"tpu", -1},    {"a", 2},    {"geforce", 2},
  };
  for (const auto& [wish, expected] : cases) {
    const auto chosen = chooseDevice(DEVICES, wish);
    EXPECT_EQ(chosen ? static_cast<int>(*chosen) : -1, expected) << wish;
  }
  EXPECT_FALSE(chooseDevice({DEVICES[1]}, "gpu")) << "a wish is no preference";
}

TEST(OpenClDevice, reads_the_environment_unless_told)
{
  ::unsetenv("MESH_TOOLS_OPENCL");
  EXPECT_EQ(deviceWish(), "");
  EXPECT_EQ(deviceWish(" GeForce RTX\n"), "geforce rtx");
  ::setenv("MESH_TOOLS_OPENCL", " CPU ", 1);
  EXPECT_EQ(deviceWish(), "cpu");
  EXPECT_EQ(deviceWish("  "), "cpu");
  EXPECT_EQ(deviceWish("off"), "off");
  EXPECT_EQ(deviceWish("Auto"), "cpu");
  for (const char* const any : {"", "auto"}) {
    ::setenv("MESH_TOOLS_OPENCL", any, 1);
    EXPECT_EQ(deviceWish(), "");
  }
  ::unsetenv("MESH_TOOLS_OPENCL");
}

TEST(OpenClDevice, is_named_in_one_line)
{
  EXPECT_EQ(DEVICES[2].text(), "GeForce RTX (NVIDIA CUDA, driver 1.0)");
}
