#pragma once

#include <cstddef>
#include <map>
#include <ostream>
#include <string>

namespace Ogre {
class SceneManager;
}

namespace osmesa_harness {

/// How much OGRE holds at one moment, for tests that nothing leaks: take one before and one after.
///
/// Nodes and movable objects are those of one scene manager (nodes: reachable from its root),
/// everything else is counted in the whole process.
struct SceneCounts
{
  std::size_t nodes = 0;
  /// By OGRE's type name, as "ManualObject" or "Entity"; types without an object are absent.
  std::map<std::string, std::size_t> movable_objects;
  std::size_t materials = 0;
  std::size_t textures = 0;
  std::size_t meshes = 0;
  std::size_t gpu_programs = 0;
  std::size_t vertex_buffers = 0;
  std::size_t index_buffers = 0;
  std::size_t vertex_buffer_bytes = 0;
  std::size_t index_buffer_bytes = 0;

  /// Number of movable objects of one type, 0 where there is none.
  std::size_t movable(const std::string& type) const;
};

SceneCounts countScene(Ogre::SceneManager* scene_manager);

bool operator==(const SceneCounts& a, const SceneCounts& b);
bool operator!=(const SceneCounts& a, const SceneCounts& b);
std::ostream& operator<<(std::ostream& stream, const SceneCounts& counts);

}  // namespace osmesa_harness
