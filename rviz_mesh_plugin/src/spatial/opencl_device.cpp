#include "spatial/opencl_device.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

namespace rviz_mesh_plugin {

namespace {

const char* const AUTOMATIC = "auto";

std::string lowerCase(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string trimmed(const std::string& text)
{
  const char* const blanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string::npos ? ""
                                    : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

bool matches(const DeviceInfo& device, const std::string& wish)
{
  if (wish == "gpu" || wish == "cpu") {
    return device.type == (wish == "gpu" ? DeviceType::GPU : DeviceType::CPU);
  }
  return lowerCase(device.name).find(wish) != std::string::npos ||
         lowerCase(device.platform).find(wish) != std::string::npos;
}

}  // namespace

std::string DeviceInfo::text() const
{
  return name + " (" + platform + ", driver " + driver + ")";
}

std::string deviceWish(const std::string& parameter)
{
  std::string wish = lowerCase(trimmed(parameter));
  if (wish.empty() || wish == AUTOMATIC) {
    const char* const variable = std::getenv("MESH_TOOLS_OPENCL");
    wish = variable ? lowerCase(trimmed(variable)) : "";
  }
  return wish == AUTOMATIC ? "" : wish;
}

std::optional<std::size_t> chooseDevice(const std::vector<DeviceInfo>& devices,
                                        const std::string& wish)
{
  std::optional<std::size_t> best;
  for (std::size_t i = 0; wish != "off" && i < devices.size(); ++i) {
    if (matches(devices[i], wish) && (!best || devices[i].type < devices[*best].type)) {
      best = i;
    }
  }
  return best;
}

}  // namespace rviz_mesh_plugin
