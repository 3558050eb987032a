#include "spatial/program_cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

namespace rviz_mesh_plugin {

namespace {

// A file is: the header, the key, the binary.
struct Header
{
  char magic[8] = {'M', 'E', 'S', 'H', 'C', 'L', '0', '1'};
  std::uint64_t key_size = 0, binary_size = 0, check_sum = 0;
};

constexpr std::uint64_t MAX_SIZE = std::uint64_t(1) << 28;  // far above any program

/// FNV-1a, 64 bits: against damage, not against malice (which the owner of the file rules out).
std::uint64_t hash(const void* data, std::size_t size, std::uint64_t value = 14695981039346656037u)
{
  for (const auto* byte = static_cast<const unsigned char*>(data); size > 0; ++byte, --size) {
    value = (value ^ *byte) * 1099511628211u;
  }
  return value;
}

std::uint64_t checkSum(const std::string& key, const ProgramCache::Binary& binary)
{
  return hash(binary.data(), binary.size(), hash(key.data(), key.size()));
}

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// Null where the descriptor is none.
File fileOf(int descriptor, const char* mode)
{
  File file(descriptor < 0 ? nullptr : ::fdopen(descriptor, mode), std::fclose);
  if (descriptor >= 0 && !file) {
    ::close(descriptor);
  }
  return file;
}

/// Makes a folder and those above it, for the user alone.
bool makeFolders(const std::string& folder)
{
  for (std::size_t end = folder.find('/', 1);; end = folder.find('/', end + 1)) {
    if (::mkdir(folder.substr(0, end).c_str(), 0700) != 0 && errno != EEXIST) {
      return false;
    }
    if (end == std::string::npos) {
      return true;
    }
  }
}

}  // namespace

std::string ProgramCache::defaultFolder()
{
  // The XDG base directory specification: a path that is not absolute does not count.
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  if (cache && cache[0] == '/') {
    return std::string(cache) + "/mesh_tools/opencl";
  }
  const char* const home = std::getenv("HOME");
  return home && home[0] == '/' ? std::string(home) + "/.cache/mesh_tools/opencl" : "";
}

ProgramCache::ProgramCache(std::string folder) : folder_(std::move(folder)) {}

std::string ProgramCache::path(const std::string& key) const
{
  char name[32];
  std::snprintf(name, sizeof name, "/%016llx.bin",
                static_cast<unsigned long long>(hash(key.data(), key.size())));
  return folder_ + name;
}

std::optional<ProgramCache::Binary> ProgramCache::load(const std::string& key) const
{
  if (folder_.empty()) {
    return std::nullopt;
  }
  // Not blocked by a pipe of that name.
  const File file =
      fileOf(::open(path(key).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK), "rb");
  struct stat status;
  Header header;
  const Header expected;
  if (!file || ::fstat(::fileno(file.get()), &status) != 0 || !S_ISREG(status.st_mode) ||
      status.st_uid != ::geteuid() || (status.st_mode & (S_IWGRP | S_IWOTH)) != 0 ||
      std::fread(&header, sizeof header, 1, file.get()) != 1 ||
      std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 ||
      header.key_size != key.size() || header.binary_size == 0 || header.binary_size > MAX_SIZE ||
      static_cast<std::uint64_t>(status.st_size) !=
          sizeof header + header.key_size + header.binary_size) {
    return std::nullopt;
  }
  std::string its_key(key.size(), '\0');
  Binary binary(header.binary_size);
  if (std::fread(&its_key[0], its_key.size(), 1, file.get()) != 1 || its_key != key ||
      std::fread(binary.data(), binary.size(), 1, file.get()) != 1 ||
      checkSum(key, binary) != header.check_sum) {
    return std::nullopt;
  }
  return binary;
}

bool ProgramCache::store(const std::string& key, const Binary& binary) const
{
  if (folder_.empty() || binary.empty() || binary.size() > MAX_SIZE || !makeFolders(folder_)) {
    return false;
  }
  Header header;
  header.key_size = key.size();
  header.binary_size = binary.size();
  header.check_sum = checkSum(key, binary);

  // Two processes may store the same at once: each writes a file of its own, and the last to rename
  // it wins.
  std::string temporary = path(key) + ".XXXXXX";
  File file = fileOf(::mkostemp(&temporary[0], O_CLOEXEC), "wb");  // with mode 600
  if (!file) {
    return false;
  }
  const bool written = std::fwrite(&header, sizeof header, 1, file.get()) == 1 &&
                       std::fwrite(key.data(), key.size(), 1, file.get()) == 1 &&
                       std::fwrite(binary.data(), binary.size(), 1, file.get()) == 1 &&
                       std::fflush(file.get()) == 0 && ::fsync(::fileno(file.get())) == 0;
  if (std::fclose(file.release()) == 0 && written &&
      ::rename(temporary.c_str(), path(key).c_str()) == 0) {
    return true;
  }
  ::unlink(temporary.c_str());
  return false;
}

}  // namespace rviz_mesh_plugin
