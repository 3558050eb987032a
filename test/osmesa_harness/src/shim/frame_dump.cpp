#include "frame_dump.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <sstream>
#include <string>

#include "shim.h"

namespace osmesa_glx {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds BETWEEN_DUMPS(500);

// True at most twice a second for each drawable.
bool isDue(XID drawable)
{
  static std::mutex mutex;
  static std::map<XID, Clock::time_point> last;
  const auto now = Clock::now();
  const std::lock_guard<std::mutex> lock(mutex);
  const auto before = last.find(drawable);
  if (before != last.end() && now - before->second < BETWEEN_DUMPS) {
    return false;
  }
  last[drawable] = now;
  return true;
}

std::string portablePixmap(const Frame& frame)
{
  std::string bytes =
      "P6\n" + std::to_string(frame.width) + " " + std::to_string(frame.height) + "\n255\n";
  bytes.reserve(bytes.size() + 3 * frame.pixels.size());
  for (const std::uint32_t pixel : frame.pixels) {
    bytes += static_cast<char>(pixel >> 16 & 0xff);
    bytes += static_cast<char>(pixel >> 8 & 0xff);
    bytes += static_cast<char>(pixel & 0xff);
  }
  return bytes;
}

bool writeFile(const std::string& path, const std::string& bytes)
{
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) {
    return false;
  }
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  return std::fclose(file) == 0 && written;
}

}  // namespace

void dumpFrame(XID drawable, const Frame& frame)
{
  static const char* const prefix = std::getenv("OSMESA_GLX_DUMP");
  if (!prefix || !*prefix || (frame.width <= 1 && frame.height <= 1) || !isDue(drawable)) {
    return;
  }
  std::ostringstream path;
  path << prefix << "-" << std::hex << drawable << ".ppm";
  const std::string temporary = path.str() + ".tmp";
  if (!writeFile(temporary, portablePixmap(frame)) ||
      std::rename(temporary.c_str(), path.str().c_str()) != 0) {
    complain("cannot write the frame to %s: %s", path.str().c_str(), std::strerror(errno));
    std::remove(temporary.c_str());
  }
}

}  // namespace osmesa_glx
