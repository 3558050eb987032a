#pragma once

#include <optional>
#include <string>
#include <vector>

namespace rviz_mesh_plugin {

/// Files that keep compiled programs from one start to the next, one per key: a text that tells all
/// that a program depends on. What goes wrong with them only costs the time to compile again.
class ProgramCache
{
 public:
  using Binary = std::vector<unsigned char>;

  /// mesh_tools/opencl in $XDG_CACHE_HOME, or in ~/.cache; empty where there is neither.
  static std::string defaultFolder();

  /// An empty folder keeps nothing.
  explicit ProgramCache(std::string folder = defaultFolder());

  /// Nothing where there is no such file, or it is damaged, of another key, or somebody else could
  /// have written it.
  std::optional<Binary> load(const std::string& key) const;

  /// Replaces the file as a whole, or leaves it as it is and returns false.
  bool store(const std::string& key, const Binary& binary) const;

  std::string path(const std::string& key) const;

 private:
  std::string folder_;
};

}  // namespace rviz_mesh_plugin
