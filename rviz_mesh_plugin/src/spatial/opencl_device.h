#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// In the order of preference.
enum class DeviceType
{
  GPU,
  CPU,
  OTHER
};

/// An OpenCL device as its drivers describe it.
struct DeviceInfo
{
  DeviceType type = DeviceType::OTHER;
  std::string name, platform;
  std::string driver;            ///< version of the driver
  std::string platform_version;  ///< which also names the compiler, in some drivers
  std::string device_version;

  /// One line: name (platform, driver).
  std::string text() const;
};

/// Which device is wished for: `parameter`, or where that is empty or "auto" the environment
/// variable MESH_TOOLS_OPENCL, in lower case without blanks around it.
///
/// "", "auto"    any device: a GPU before a CPU before others
/// "off"         none: everything is answered natively
/// "gpu", "cpu"  a device of that type
/// other text    a device whose name, or that of its platform, contains it; a GPU before ...
///
/// Python's mesh_map reads the variable alike.
std::string deviceWish(const std::string& parameter = "");

/// Index of the device that a wish (of deviceWish()) takes. Of several as good, the first.
std::optional<std::size_t> chooseDevice(const std::vector<DeviceInfo>& devices,
                                        const std::string& wish);

}  // namespace rviz_mesh_plugin
