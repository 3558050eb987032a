#include "rviz_mesh_plugin/mesh_registry.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <mutex>
#include <vector>

namespace rviz_mesh_plugin {
namespace {

struct Registry
{
  std::mutex mutex;
  std::vector<std::weak_ptr<const MeshData>> meshes;
  std::vector<std::weak_ptr<const MeshLayout>> layouts;
};

/// Never destroyed: threads may still use it while the process ends.
Registry& registry()
{
  static Registry& instance = *new Registry;
  return instance;
}

template <class T>
void forgetUnused(std::vector<std::weak_ptr<const T>>& entries)
{
  entries.erase(std::remove_if(entries.begin(), entries.end(),
                               [](const auto& entry) { return entry.expired(); }),
                entries.end());
}

template <class T>
bool sameBytes(const std::vector<T>& a, const std::vector<T>& b)
{
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool sameContent(const MeshData& a, const MeshData& b)
{
  return a.uuid == b.uuid && a.frame_id == b.frame_id && a.normals_given == b.normals_given &&
         sameBytes(a.indices, b.indices) && sameBytes(a.vertices, b.vertices);
}

}  // namespace

MeshDataConstPtr internMesh(const MeshDataConstPtr& mesh)
{
  auto& entries = registry();
  const std::lock_guard<std::mutex> lock(entries.mutex);
  for (const auto& entry : entries.meshes) {
    const MeshDataConstPtr known = entry.lock();
    if (known && (known == mesh || sameContent(*known, *mesh))) {
      return known;
    }
  }
  forgetUnused(entries.meshes);
  entries.meshes.push_back(mesh);
  return mesh;
}

MeshLayoutConstPtr findLayout(const MeshDataConstPtr& mesh, Split split,
                              const MaterialsConstPtr& materials)
{
  auto& entries = registry();
  const std::lock_guard<std::mutex> lock(entries.mutex);
  for (const auto& entry : entries.layouts) {
    const MeshLayoutConstPtr known = entry.lock();
    if (known && known->mesh == mesh && known->split == split &&
        (split != Split::BY_MATERIAL || known->materials == materials)) {
      return known;
    }
  }
  return nullptr;
}

void rememberLayout(const MeshLayoutConstPtr& layout)
{
  auto& entries = registry();
  const std::lock_guard<std::mutex> lock(entries.mutex);
  forgetUnused(entries.layouts);
  entries.layouts.push_back(layout);
}

}  // namespace rviz_mesh_plugin
